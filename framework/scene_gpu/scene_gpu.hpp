// SPDX-License-Identifier: Apache-2.0
// A scene on the device: vertices, indices, instances, blocks of triangles, materials, lights and
// texture arrays, and the list of draws. Made once per scene; graphs import its resources. Passes
// read the draw list and the handles, never the Vulkan objects.
#pragma once

#include "framework/gpu/buffer.hpp"
#include "framework/gpu/image.hpp"
#include "framework/runtime/executor.hpp"
#include "framework/scene_gpu/scene_facts.hpp"

#include <cstdint>
#include <optional>
#include <vector>

namespace ockham {

/// One indexed, instanced draw: triangles of one material.
struct Draw {
    std::uint32_t first_index = 0, index_count = 0;
    std::int32_t vertex_offset = 0;
    std::uint32_t first_instance = 0, instance_count = 0;
    std::uint32_t material = 0;
    std::uint32_t first_block = 0; ///< of shader::TriangleBlock, of the first instance
    std::uint32_t blocks_per_instance = 0;
    bool masked = false;
    bool double_sided = false;
    bool mirrored = false; ///< the instances' transforms turn front faces clockwise
};

/// A vertex is a row of vec4s: (position, u), (normal, v), then what the scene has of the others,
/// one vec4 each; kNone: it has none.
struct VertexLayout {
    std::uint32_t stride = 2; ///< vec4s
    std::uint32_t tangent = kNone;
    std::uint32_t uv1 = kNone;
    std::uint32_t color = kNone;
};

/// The scene's resources in one graph. Empty handles: the scene does not need them.
struct SceneHandles {
    BufferHandle vertices, indices, instances, triangle_blocks, materials, lights;
    ImageHandle color_textures, data_textures;
};

class SceneGpu {
public:
    /// Uploads what `scene` needs. Throws Error(device) where it does not fit, Error(input) where a
    /// limit of the formats is passed (materials, texture coordinates).
    SceneGpu(gpu::Device& device, const Scene& scene);

    const SceneFacts& facts() const { return facts_; }
    const VertexLayout& vertex_layout() const { return layout_; }
    const std::vector<Draw>& draws() const { return draws_; }
    const Bounds& bounds() const { return bounds_; }
    std::uint64_t bytes() const { return bytes_; }
    /// Bytes of texture arrays that images smaller than the largest leave unused.
    std::uint64_t padding_bytes() const { return padding_bytes_; }

    /// Declares the resources in a graph; bind() gives them to its executor.
    SceneHandles import(Graph& graph) const;
    void bind(Executor& executor, const SceneHandles& handles) const;

private:
    SceneFacts facts_;
    VertexLayout layout_;
    std::vector<Draw> draws_;
    Bounds bounds_;
    std::uint64_t bytes_ = 0;
    std::uint64_t padding_bytes_ = 0;
    std::optional<gpu::Buffer> vertices_, indices_, instances_, triangle_blocks_, materials_,
        lights_;
    std::optional<gpu::Image> color_textures_, data_textures_;
};

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
// A volume on the device: its field as a 3D image, its transfer table, its environment map. Made
// once per volume; the tables may be replaced between executions. Graphs import its resources.
// Passes see handles and facts, never the Vulkan objects.
#pragma once

#include "framework/core/image.hpp"
#include "framework/gpu/buffer.hpp"
#include "framework/gpu/image.hpp"
#include "framework/runtime/executor.hpp"
#include "framework/scene/transfer_function.hpp"
#include "framework/scene/volume.hpp"

#include <cstdint>
#include <optional>

namespace ockham {

namespace gpu {
class Uploader;
} // namespace gpu

/// What of a volume and its light decides which passes, variants and bytes exist.
struct VolumeFacts {
    glm::uvec3 dims{0};
    glm::uvec3 cells{0};          ///< of ranges: dims / RANGE_CELL, rounded up
    bool emission = false;        ///< the transfer function emits
    bool homogeneous = false;     ///< one extinction everywhere: one majorant, no grid
    bool environment_map = false; ///< else the environment is one colour

    bool operator==(const VolumeFacts&) const = default;
};

/// The volume's resources in one graph. Empty handles: the volume does not need them.
struct VolumeHandles {
    /// 3D: R8_UNORM (on software devices R16_UNORM, for the filter's sake), R16_UNORM (int16 +
    /// 32768) or R32_SFLOAT by the voxel type. A single slice is there twice.
    ImageHandle volume;
    BufferHandle transfer; ///< vec4 per entry
    BufferHandle emission; ///< vec3 per entry
    /// float[levels][entries]: greatest opacity of 2^level entries from each on (fewer at the end);
    /// not where homogeneous.
    BufferHandle opacity_max;
    ImageHandle environment;        ///< rgba32f, row 0 at +z: shaders/volume/environment.glsl
    BufferHandle environment_table; ///< what chooses its texels, as listed there
};

class VolumeGpu {
public:
    /// Uploads. `environment`: linear R, G, B, equirectangular; empty where it is one colour.
    /// Throws Error(device) where it does not fit the device's limits, with the numbers, and
    /// Error(input) for an environment without these channels or with a texel that is no radiance,
    /// and for more than 8176 voxels along an axis.
    VolumeGpu(gpu::Device& device, const Volume& volume, const TransferFunction& transfer,
        const Image& environment = {});

    const VolumeFacts& facts() const { return facts_; }
    const TransferTable& table() const { return table_; }
    std::uint64_t bytes() const { return bytes_; }
    /// Texel units, as kernels see the field, from data units.
    float texel_of(double value) const;
    /// Greatest opacity of the values that occur; a little above where rounding could exceed it.
    float max_opacity() const;
    glm::uvec2 environment_size() const { return environment_size_; } ///< 0: no map
    glm::vec3 environment_mean() const { return environment_mean_; }  ///< radiance, over directions

    /// Another transfer function. True: the facts have changed, so graphs must be declared anew.
    bool set_transfer(const TransferFunction& transfer);

    VolumeHandles import(Graph& graph) const;
    void bind(Executor& executor, const VolumeHandles& handles) const;

private:
    void make_volume(gpu::Uploader& uploader, const Volume& volume);
    void make_environment(gpu::Uploader& uploader, const Image& map);
    void make_tables(gpu::Uploader& uploader);
    void describe_transfer();

    gpu::Device* device_;
    VolumeFacts facts_;
    TransferTable table_;
    std::uint64_t bytes_ = 0;
    double texel_scale_ = 1, texel_offset_ = 0; ///< texel = value * scale + offset
    Volume extremes_; ///< two voxels: the volume's least and greatest; what tables are made for
    glm::uvec2 environment_size_{0};
    glm::vec3 environment_mean_{0.0f};
    std::optional<gpu::Image> volume_, environment_;
    std::optional<gpu::Buffer> transfer_, emission_, opacity_max_, environment_table_;
};

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
// The meshes of a picture that has a medium in it, as part of the medium's graph: adaptive
// supersampling of surfaces that are lit through the medium, once for each view, and where the
// camera's rays end. No picture of its own: volume_gi.hpp declares, executes and adds the medium.
#pragma once

#include "passes/pipelines/aa_graph.hpp"
#include "passes/pipelines/lit_scene.hpp"

namespace ockham {

class MeshBackground {
public:
    /// `device` and `scene` must outlive it. Throws Error(input) for parameters out of range, and
    /// for methods whose pictures are no means of samples.
    MeshBackground(gpu::Device& device, const LitScene& scene, const AdaptiveAaParams& params);

    /// What later executions show, and its size in pixels. `isosurfaces`: where they are, if any.
    /// `origin`: of the part, with AdaptiveAaParams::part_of only.
    void show(const Camera& camera, glm::uvec2 size, glm::uvec2 origin, const Bounds& isosurfaces);
    /// What kernels on volumes need to know of it.
    void describe(shader::VolumeFrame& frame) const;

    /// Whom the medium sends to the meshes.
    struct Use {
        bool rays = true;      ///< the camera's, which end there
        bool scatters = false; ///< paths that have been scattered
    };
    /// Adds the passes, which run where `new_view` holds. `medium` without meshes. Throws
    /// Error(device) where the tree for what scatters is more than a kernel can bind.
    MeshInputs declare(Graph& graph, const MediumInputs& medium, Use use, Condition new_view);
    void bind(Executor& executor) const;

    /// k of the last declare(), kept between executions, r8ui; empty: every pixel has as many.
    ImageHandle sample_count() const { return sample_count_; }
    const AdaptiveAaParams& params() const { return params_; }

private:
    BufferHandle import_tree(Graph& graph, bool scatters);

    gpu::Device& device_;
    const LitScene& lit_;
    AdaptiveAaParams params_;
    std::uint32_t max_extent_;
    ScreenTile view_;
    shader::FrameData shown_{};
    gpu::Buffer frame_buffer_;
    std::optional<gpu::Buffer> tree_buffer_; ///< from the first medium on that scatters
    SceneHandles scene_;
    BufferHandle frame_, tree_;
    ImageHandle sun_map_, sample_count_;
};

} // namespace ockham

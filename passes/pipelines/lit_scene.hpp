// SPDX-License-Identifier: Apache-2.0
// A scene ready to be shaded: uploaded, with the shadow map of its sun rendered. Made once per
// scene and shared by all pictures of it.
#pragma once

#include "framework/scene_gpu/scene_gpu.hpp"

#include <optional>
#include <vector>

namespace ockham {

class LitScene {
public:
    static constexpr std::uint32_t kShadowMapSize = 4096;

    /// Uploads, and executes the shadow map's graph where the sun casts a shadow.
    /// `device` must outlive this object.
    LitScene(gpu::Device& device, Scene scene);

    const Scene& scene() const { return scene_; }
    const SceneGpu& gpu() const { return gpu_; }
    /// Nothing where the sun casts no shadow.
    const gpu::Image* shadow_map() const { return shadow_map_ ? &*shadow_map_ : nullptr; }
    /// GPU times of the preparation; empty without a shadow map.
    const std::vector<PassTime>& times() const { return times_; }

private:
    Scene scene_;
    SceneGpu gpu_;
    std::optional<gpu::Image> shadow_map_;
    std::vector<PassTime> times_;
};

} // namespace ockham

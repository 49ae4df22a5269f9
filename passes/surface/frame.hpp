// SPDX-License-Identifier: Apache-2.0
// Everything about one picture that its kernels share: camera, size, window width, sample order.
// Builds the FrameData of shaders/shared/frame.h; pipelines upload it once per frame.
#pragma once

#include "framework/scene/scene.hpp"
#include "shaders/shared/frame.h"

#include <cstdint>
#include <string>
#include <vector>

namespace ockham {

/// sample_order(SampleOrder::paper, m).
std::vector<std::uint32_t> paper_order(int m);

/// `width`, `height`: pixels. `m`: window width, 1 ... 8, order.size() == m * m. `bounds`: of the
/// meshes, that cast shadows; `others`: of what else is seen.
shader::FrameData make_frame(const Scene& scene, const Bounds& bounds, const Camera& camera,
    int width, int height, int m, const std::vector<std::uint32_t>& order, int shadow_map_size,
    const Bounds& others = {});

/// Moves all samples of a frame that was made without: `jitter` in samples, to the right and down.
void set_jitter(shader::FrameData& frame, glm::vec2 jitter);

} // namespace ockham

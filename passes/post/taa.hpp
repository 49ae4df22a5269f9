// SPDX-License-Identifier: Apache-2.0
// Temporal anti-aliasing: one sample per pixel and frame, at places that change from frame to
// frame, gathered in a history that follows the camera. A baseline; its programs jitter FrameData
// by taa_jitter() before each execution.
#pragma once

#include "passes/surface/gbuffer.hpp"

namespace ockham {

struct TaaInputs {
    BufferHandle frame;
    Gbuffer gbuffer;      ///< of one sample per pixel
    ImageHandle radiance; ///< rgba32f, linear, this frame's
};

/// Returns "taa": rgba32f, linear, a history of the graph. While the camera stands still it is the
/// mean of all frames; from its first move on the last ten weigh.
ImageHandle add_taa(Graph& graph, const TaaInputs& in);

/// Where frame number `index` (from 0) takes its samples, in pixels from their centres: the Halton
/// sequence in bases 2 and 3, within [-1/2, 1/2).
glm::vec2 taa_jitter(std::uint32_t index);

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
// Hysteresis for moving cameras: the variance that pixels are expected to have rises at once and
// falls little by little, along with the surface that it belongs to. Counts then change less from
// frame to frame. Exists only in sequences of frames.
#pragma once

#include "framework/graph/graph.hpp"

namespace ockham {

/// Of 0 to 0.9, steps of 4 mm on Sponza and the atrium: most of the gain, 2 % more samples.
inline constexpr float kKeptVariance = 0.8f;

struct VarianceHistoryInputs {
    BufferHandle frame, frame_before; ///< FrameData of this execution and of the one before
    ImageHandle variance;             ///< rg32f, from add_ockham_metrics
    ImageHandle first_surface;        ///< rg32ui, from add_clusters
};

/// Returns "variance_history": rg32f, in the form of `variance` and in its place. In the first
/// execution it equals `variance`. `keep` in [0, 1): share of a fall that is held back.
ImageHandle add_variance_history(
    Graph& graph, const VarianceHistoryInputs& in, float keep = kKeptVariance);

} // namespace ockham

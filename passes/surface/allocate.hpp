// SPDX-License-Identifier: Apache-2.0
// Samples for pixels, from the variance that their colours are expected to have: as many as pay for
// themselves at one price lambda. The other way to allocate is budget.
#pragma once

#include "framework/graph/graph.hpp"

namespace ockham {

/// The price that the default metric asks for a sample: about 43 dB on the scenes of docs/passes/metrics_ockham.md.
inline constexpr float kDefaultLambda = 1.5e-5f;

struct AllocateParams {
    std::uint32_t samples = 1;     ///< n, 1 ... 64
    float lambda = kDefaultLambda; ///< squared display-encoded error per sample; 0: n, infinity: 1
    bool winner = false;           ///< also write what asked for the samples
};

struct Allocation {
    ImageHandle sample_count; ///< r8ui, k = 1 ... n
    ImageHandle winner;       ///< r8ui, WINNER_* of shaders/surface/metrics.h; only on request
};

/// `variance`: rg32f as shaders/surface/variance.glsl has it, with the law for k.
Allocation add_allocate(Graph& graph, ImageHandle variance, const AllocateParams& params);

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
// The default metric: the variance that each pixel's n colours are expected to have, from the
// surfaces in its window and from S around it. How many samples that is worth is decided by
// allocate, for one lambda, or by budget, for a share of all samples.
#pragma once

#include "passes/surface/clusters.hpp"

namespace ockham {

struct OckhamMetricsInputs {
    BufferHandle frame;
    Gbuffer gbuffer; ///< packed with slopes, or visibility
    Clusters clusters;
    ImageHandle first_sample;
};

struct OckhamMetricsParams {
    std::uint32_t m = 1;     ///< window width in samples, 1 ... 8
    bool stratified = false; ///< the resolve weighs surfaces by coverage, not samples alike
};

/// Returns "variance", rg32f, one texel a pixel: shaders/surface/variance.glsl.
ImageHandle add_ockham_metrics(
    Graph& graph, const OckhamMetricsInputs& in, const OckhamMetricsParams& params);

} // namespace ockham

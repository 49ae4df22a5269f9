// SPDX-License-Identifier: Apache-2.0
// How many samples each pixel needs, from its window in the G-buffer and from S around it: the
// metrics of Hollaender et al. 2013, section 3.1, as printed.
#pragma once

#include "passes/surface/gbuffer.hpp"

namespace ockham {

struct MetricsInputs {
    BufferHandle frame;
    Gbuffer gbuffer;
    ImageHandle first_sample;
};

/// The paper gives no constants; these were fixed once on builtin:atrium (docs/passes/metrics.md).
struct MetricsParams {
    std::uint32_t width = 0, height = 0;
    float depth_weight = 60.0f;   ///< c_d, samples per squared world unit, >= 0
    float normal_weight = 12.0f;  ///< c_n, samples, >= 0
    float shading_weight = 40.0f; ///< c_s, samples per unit of luma, >= 0
    float range_min = 0.0312f;    ///< t_min: smaller luma ranges count as flat
    float range_edge = 0.125f;    ///< t_edge: so do ranges below this share of the brightest
    bool winner = false;          ///< also write which metric asked for the most
};

/// The constants for a window of m x m samples. They count samples, of which a wider window has
/// more, so the three weights grow with m: 15 m, 3 m and 10 m; the members' defaults are m = 4's.
MetricsParams default_metrics(std::uint32_t m);

struct Metrics {
    ImageHandle sample_count; ///< r8ui, k = 1 ... n
    ImageHandle winner;       ///< r8ui, WINNER_* of shaders/surface/metrics.h; only on request
};

Metrics add_metrics(Graph& graph, const MetricsInputs& in, const MetricsParams& params);

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
// Shades k samples of each pixel's window and sums them: the same k everywhere, k from a map in a
// loop, or one indirect dispatch per count over buckets. Loop and buckets give equal sums, bit for
// bit; all three do at k = m * m.
#pragma once

#include "passes/schedule/buckets.hpp"
#include "passes/surface/shading_inputs.hpp"

namespace ockham {

/// Every pixel alike: no S, no map; k in 1 ... m * m. k = m * m is full supersampling.
ImageHandle add_shade_uniform(
    Graph& graph, const ShadingInputs& in, const ShadingParams& params, std::uint32_t k);

/// k from `sample_count`, each invocation loops for its own pixel (the paper's plain loop).
ImageHandle add_shade_loop(Graph& graph, const ShadingInputs& in, const ShadingParams& params,
    ImageHandle first_sample, ImageHandle sample_count);

/// One indirect dispatch per count over the pixels of its bucket.
ImageHandle add_shade_buckets(Graph& graph, const ShadingInputs& in, const ShadingParams& params,
    ImageHandle first_sample, const Buckets& buckets);

// All return "shaded_sum": rgba32f, sum of radiance and hits over the k samples. Pixels with k = 1
// are left undefined where S holds them. Work beyond the iteration budget of one kernel is split
// over several passes, "shade", "shade.1", ..., which continue the same sums.

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
// Shades k samples of each pixel's window and sums them: the same k everywhere, or k from a map by
// one of several back ends, which differ in how pixels meet lanes (Hollaender et al. 2013, section
// 4.2, and beyond). All give equal sums, bit for bit.
#pragma once

#include "passes/schedule/buckets.hpp"
#include "passes/schedule/tile_list.hpp"
#include "passes/surface/shading_inputs.hpp"

namespace ockham {

/// What a map of counts brings along.
struct AdaptiveInputs {
    ImageHandle first_sample; ///< S
    ImageHandle sample_count; ///< r8ui, 1 ... m * m
    /// Labels of surfaces (shaders/surface/clusters.glsl), among which picks are shared out; empty:
    /// the first samples in order are taken, whatever they lie on.
    ImageHandle clusters;
};

/// Every pixel alike: no S, no map; k in 1 ... m * m. k = m * m is full supersampling.
ImageHandle add_shade_uniform(
    Graph& graph, const ShadingInputs& in, const ShadingParams& params, std::uint32_t k);

/// Each invocation loops for its own pixel, as often as its count says: the paper's choice.
ImageHandle add_shade_loop(Graph& graph, const ShadingInputs& in, const ShadingParams& params,
    const AdaptiveInputs& counts);

/// One indirect dispatch per count over the pixels of its bucket.
ImageHandle add_shade_buckets(Graph& graph, const ShadingInputs& in, const ShadingParams& params,
    const AdaptiveInputs& counts, const Buckets& buckets);

/// One indirect dispatch over the pixels sorted by count.
ImageHandle add_shade_sorted(Graph& graph, const ShadingInputs& in, const ShadingParams& params,
    const AdaptiveInputs& counts, const Buckets& buckets);

/// One workgroup per tile with work spreads the tile's (pixel, sample) pairs over its lanes.
ImageHandle add_shade_repacked(Graph& graph, const ShadingInputs& in, const ShadingParams& params,
    const AdaptiveInputs& counts, const TileList& tiles);

/// What tells the pixels of one count from others while they are drawn.
enum class CountTest {
    depth,   ///< counts as depths; needs nothing that Vulkan does not promise on the desktop
    stencil, ///< counts as stencils; needs Device::exports_stencil()
};
/// One draw over the whole picture per count, and a test that stops the pixels of other counts.
ImageHandle add_shade_tested(Graph& graph, const ShadingInputs& in, const ShadingParams& params,
    const AdaptiveInputs& counts, CountTest test);

// All return "shaded_sum": rgba32f, sum of radiance and hits over the k samples. Pixels with k = 1
// are left undefined where S holds them. Work beyond the iteration budget of one kernel is split
// over several passes, "shade", "shade.1", ..., which continue the same sums.

} // namespace ockham

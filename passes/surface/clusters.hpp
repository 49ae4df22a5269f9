// SPDX-License-Identifier: Apache-2.0
// Which surfaces each pixel sees: labels for all n samples of its window, and how much normals vary
// within each. The one pass that walks over whole windows besides shading; the metric, the
// stratified resolve and normal filtering read what it leaves. Exists only where one of them does.
#pragma once

#include "passes/surface/gbuffer.hpp"

namespace ockham {

struct ClustersParams {
    std::uint32_t width = 0, height = 0; ///< pixels
    std::uint32_t m = 1;                 ///< window width in samples, 1 ... 8
};

/// One texel a pixel.
struct Clusters {
    /// 2 bits a sample, in the order in which they are taken (shaders/surface/clusters.glsl):
    /// r32ui up to 16 samples, else rgba32ui.
    ImageHandle labels;
    /// rgba8, channel = label: deviation of the normals' slopes within it, sqrt(1 / r - 1) with
    /// r = |mean normal|; 1 also beyond; 0 for labels that do not occur.
    ImageHandle normal_spread;
    /// rg32ui: stored depth of the first sample as bits, 0 = background; its material.
    ImageHandle first_surface;
};

/// `frame`: its order says which sample is first. `gbuffer`: packed needs its slopes.
Clusters add_clusters(Graph& graph, BufferHandle frame, const Gbuffer& gbuffer,
    const ClustersParams& params, const std::string& reason);

} // namespace ockham

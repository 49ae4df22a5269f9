// SPDX-License-Identifier: Apache-2.0
// What a sample that stands for others takes from all samples of its surface: the mean of their
// base colours, and lobes wide enough for their normals. Not the shading that uses it: picks.glsl,
// first_sample.comp. Called by the pictures of passes/pipelines that shade some samples of many.
#pragma once

#include "passes/surface/clusters.hpp"

namespace ockham {

struct SurfaceMeansParams {
    std::uint32_t width = 0, height = 0; ///< pixels
    std::uint32_t anisotropy = 16;       ///< most texture taps per lookup, 1 ... 16
    bool albedo = false; ///< base colours too, n lookups a pixel; else only the width of lobes
};

/// Returns "surface_means", one texel a pixel, rgba32ui with colours, else r32ui:
/// shaders/surface/surface_means.glsl.
ImageHandle add_surface_means(Graph& graph, const SceneInputs& scene, const Gbuffer& gbuffer,
    const Clusters& clusters, const SurfaceMeansParams& params);

} // namespace ockham

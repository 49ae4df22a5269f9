// SPDX-License-Identifier: Apache-2.0
// Where the ray through each pixel's centre first meets an isosurface, in one of three ways, so
// that they can be compared; passes that want exact hits of jittered rays call find_surface() of
// shaders/volume/surface.glsl themselves. Needs at least one isovalue.
#pragma once

#include "passes/volume/medium_inputs.hpp"

#include <cstdint>

namespace ockham {

enum class SurfaceSearch {
    stochastic, ///< the paper's Algorithm 1: refined from execution to execution, may miss what is
                ///< thin
    march,      ///< jittered steps, then bisection; misses what lies between two steps
    exact,      ///< min/max cells, then the roots of the field; misses nothing
};

struct SurfaceDepthParams {
    std::uint32_t width = 0, height = 0; ///< pixels, those of the frame
    SurfaceSearch search = SurfaceSearch::exact;
    std::uint32_t candidates = 1; ///< stochastic: per pixel and execution, 1 to 32768
    std::uint32_t steps = 512;    ///< march: per ray, 1 to 32768
};

struct SurfaceDepth {
    /// rg32f: t as a fraction of the ray's way through crop box and clip planes, 0 to 1; 1 + index
    /// of the surface, or 0 for none. Stochastic: persistent.
    ImageHandle depth;
    ImageHandle candidates; ///< r32ui, persistent, stochastic alone: tried so far
};

/// `restart` (stochastic alone): forget what was found, as when the camera, the field or an
/// isovalue has changed. Cost: docs/passes/surface_depth.md.
SurfaceDepth add_surface_depth(
    Graph& graph, const MediumInputs& in, const SurfaceDepthParams& params, Condition restart);

} // namespace ockham

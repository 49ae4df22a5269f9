// SPDX-License-Identifier: Apache-2.0
// FXAA (Lottes 2009; 3.11, quality path): finds edges in the finished picture and moves pixels
// along them towards the other side. A baseline: knows nothing of geometry and shades nothing.
#pragma once

#include "framework/graph/graph.hpp"

namespace ockham {

struct FxaaParams {
    float subpixel = 0.75f;        ///< blur of what is narrower than a pixel, 0 ... 1
    float threshold = 0.125f;      ///< luma ranges below this share of the brightest are no edge
    float threshold_min = 0.0312f; ///< nor are ranges below this
};

/// `radiance`: rgba32f, linear; `display`: of add_display(). Returns "fxaa", rgba32f. Pixels that
/// are on no edge pass bit for bit; the others are clamped to what a display shows. Alpha passes.
ImageHandle add_fxaa(
    Graph& graph, ImageHandle radiance, ImageHandle display, const FxaaParams& params = {});

} // namespace ockham

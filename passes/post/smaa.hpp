// SPDX-License-Identifier: Apache-2.0
// SMAA 1x (Jimenez et al. 2012): finds edges in the finished picture, guesses the line that each
// stands for from how it ends, and blends pixels by the areas which that line cuts off. A baseline:
// knows nothing of geometry and shades nothing. Luma edges, diagonals, corners.
#pragma once

#include "framework/graph/graph.hpp"

namespace ockham {

struct SmaaParams {
    float threshold = 0.1f; ///< luma steps from here on are edges, 0 ... 0.5
};

struct Smaa {
    ImageHandle edges;    ///< r8ui, SMAA_EDGE_* of shaders/post/smaa.h
    ImageHandle weights;  ///< rgba16f, shaders/post/smaa_weights.comp
    ImageHandle radiance; ///< rgba32f, "smaa"; pixels without weights pass bit for bit
};

/// `radiance`: rgba32f, linear; `display`: of add_display().
Smaa add_smaa(
    Graph& graph, ImageHandle radiance, ImageHandle display, const SmaaParams& params = {});

} // namespace ockham

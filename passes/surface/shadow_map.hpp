// SPDX-License-Identifier: Apache-2.0
// Distances from the sun to what it meets first, for the main directional light. The sun and the
// scene stand still, so programs run it once in a graph of its own and import the map.
#pragma once

#include "passes/surface/draw_scene.hpp"

namespace ockham {

/// Writes `map` (d32, square: the whole scene's box along the sun), reversed: 1 nearest to the
/// sun, 0 where nothing is met.
ImageHandle add_shadow_map(Graph& graph, const SceneInputs& in, ImageHandle map);

} // namespace ockham

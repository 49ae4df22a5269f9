// SPDX-License-Identifier: Apache-2.0
// Draws pixels large, and of the one in the middle all its samples: colour, value, whether it was
// taken. What they are comes from the technique. Called by the viewer.
#pragma once

#include "samples/viewer/canvas.hpp"

#include <glm/glm.hpp>

#include <cstdint>
#include <vector>

namespace ockham::viewer {

/// The m x m samples of one pixel, row by row.
struct SampleGrid {
    std::uint32_t m = 1;
    std::vector<glm::vec3> radiance;  ///< linear
    std::vector<std::uint32_t> ranks; ///< in the order in which they are taken, from 0
    std::uint32_t count = 1;          ///< k: so many are shaded
    bool by_rank = true;              ///< those of lower ranks; else, surface by surface
    std::uint64_t paths = 0;          ///< of whose light a value is the mean; 0: it is exact
};

/// `pixel` of the canvas, with those around it. Coordinates beyond its borders are black.
void draw_loupe(const Canvas& canvas, glm::ivec2 pixel);
/// Hovering shows a sample's value.
void draw_samples(const SampleGrid& grid, const Look& look);

} // namespace ockham::viewer

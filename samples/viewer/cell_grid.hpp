// SPDX-License-Identifier: Apache-2.0
// Grids of cells in a volume as the camera sees them: which cells each pixel's ray passes, and
// pictures of that. On the host, for overlays; kernels walk grids by themselves. Called by the
// viewer.
#pragma once

#include "framework/core/image.hpp"
#include "framework/scene/camera.hpp"
#include "framework/scene/volume.hpp"

#include <functional>

namespace ockham::viewer {

/// Cells of `side` voxels each way, x fastest, over the box of a volume; at the far sides the rest.
struct CellGrid {
    VolumePlace place;
    glm::uvec3 dims{1}; ///< voxels
    std::uint32_t side = 1;
    glm::uvec3 cells() const { return (dims + (side - 1)) / side; }
};

/// Calls `visit` with the index of each cell that the ray through the middle of `pixel` passes,
/// from the camera on, until it says false.
void walk(const CellGrid& grid, const Camera& camera, glm::ivec2 size, glm::ivec2 pixel,
    const std::function<bool(std::size_t cell)>& visit);

/// How many of the cells that `counts` names each pixel's ray passes: one channel.
Image count_cells(const CellGrid& grid, const Camera& camera, glm::ivec2 size,
    const std::function<bool(std::size_t cell)>& counts);

/// A colour for the first such cell, by its index: R, G, B from 0 to 1; black where there is none.
Image color_cells(const CellGrid& grid, const Camera& camera, glm::ivec2 size,
    const std::function<bool(std::size_t cell)>& counts);

} // namespace ockham::viewer

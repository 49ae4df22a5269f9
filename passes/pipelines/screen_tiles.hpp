// SPDX-License-Identifier: Apache-2.0
// How a picture whose samples do not fit is cut into screen tiles of one size, with an apron of
// pixels that only their neighbours look at. Arithmetic alone; pipelines render and assemble.
#pragma once

#include "framework/core/image.hpp"

#include <glm/glm.hpp>

#include <cstdint>
#include <vector>

namespace ockham {

/// What one tile shows, and which of its pixels count.
struct TilePlacement {
    glm::uvec2 origin;      ///< its first pixel in the picture
    glm::uvec2 first, last; ///< pixels of the picture that it gives: first ... last - 1
};

/// The largest tile extent of at most `most` pixels by which `length` can be cut: whole blocks of
/// `block` pixels stay in one tile. 0: even a tile of one block and its apron is too wide.
std::uint32_t tile_extent(
    std::uint32_t length, std::uint32_t most, std::uint32_t apron, std::uint32_t block);

/// Tiles of `extent` pixels each, as tile_extent() gives them, row by row; all lie inside the
/// picture, so those at its far sides overlap more than the apron. `apron`: a multiple of `block`.
std::vector<TilePlacement> place_tiles(
    glm::uvec2 picture, glm::uvec2 extent, std::uint32_t apron, std::uint32_t block);

/// Copies what `tile` gives into `whole`. Both have `scale` texels per pixel and axis; `whole` is
/// made on first use.
void paste_tile(Image& whole, const Image& tile, const TilePlacement& placement, glm::uvec2 picture,
    std::uint32_t scale);

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
// Lists the tiles of 8 x 8 pixels in which some pixel wants more than one sample, so that one
// indirect dispatch works through them and leaves the others out. Deterministic: no atomics, no
// read-back.
#pragma once

#include "framework/graph/graph.hpp"

#include <cstdint>

namespace ockham {

/// Layouts: shaders/schedule/tile_list.h.
struct TileList {
    BufferHandle list;      ///< uint: how many; then x | y << 16 of each, in tiles, in Morton order
    BufferHandle arguments; ///< DispatchArguments: one workgroup per tile, spread over two axes
};

/// `sample_count`: r8ui, `width` x `height` pixels, each at most 65,535.
TileList add_tile_list(
    Graph& graph, ImageHandle sample_count, std::uint32_t width, std::uint32_t height);

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
// The tiles of a picture in which some pixel wants more than one sample.
#ifndef OCKHAM_SHADERS_SCHEDULE_TILE_LIST_H
#define OCKHAM_SHADERS_SCHEDULE_TILE_LIST_H

#include "schedule/buckets.h"

OCKHAM_SHARED_BEGIN

#define TILE_LIST_WIDTH 256 // invocations that compact the list

struct TileListPush {
    uvec2 size;      ///< picture in pixels
    uvec2 tile_bits; ///< log2 of the grid of BUCKET_TILE tiles, padded to powers of two
};

OCKHAM_SHARED_END

#endif

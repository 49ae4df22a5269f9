// SPDX-License-Identifier: Apache-2.0
// Items (pixels) sorted by a small count, without atomics: tile histograms, scan, stable scatter.
#ifndef OCKHAM_SHADERS_SCHEDULE_BUCKETS_H
#define OCKHAM_SHADERS_SCHEDULE_BUCKETS_H

#include "shared/types.h"

OCKHAM_SHARED_BEGIN

#define BUCKET_TILE 8        // a tile is 8 x 8 pixels
#define BUCKET_GROUP 64      // workgroup size that the indirect arguments are for
#define BUCKET_SCAN_WIDTH 256
#define MAX_BUCKETS 64

/// Items of one count: pixel_list[first] ... pixel_list[first + count - 1].
struct Bucket {
    uint first;
    uint count;
};

/// VkDispatchIndirectCommand.
struct DispatchArguments {
    uint x;
    uint y;
    uint z;
};

struct BucketPush {
    uvec2 size;       ///< picture in pixels
    uvec2 tile_bits;  ///< log2 of the tile grid, padded to powers of two
    uint bucket_count; ///< largest count; bucket b holds the items of count b + 1
};

OCKHAM_SHARED_END

#ifdef GL_core_profile
/// Tile number to tile position, in Morton order as far as both axes have bits, then linear.
uvec2 tile_position(uint tile, uvec2 bits) {
    uint shared_bits = min(bits.x, bits.y);
    uvec2 position = uvec2(0u);
    for (uint b = 0u; b < shared_bits; ++b) {
        position.x |= ((tile >> (2u * b)) & 1u) << b;
        position.y |= ((tile >> (2u * b + 1u)) & 1u) << b;
    }
    uint rest = tile >> (2u * shared_bits);
    if (bits.x > bits.y) position.x |= rest << shared_bits;
    else position.y |= rest << shared_bits;
    return position;
}
#endif

#endif

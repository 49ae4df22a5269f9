// SPDX-License-Identifier: Apache-2.0
// reads sample_count, scanned tile_histogram, bucket_table; writes pixel_list, ordered by count,
// then tile, then row by row inside the tile. x in the low 16 bits of an item, y in the high.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "schedule/buckets.h"

layout(local_size_x = 64) in;

layout(binding = 0, r8ui) uniform readonly uimage2D sample_count;
layout(scalar, binding = 1) buffer TileHistogram { uint items[]; } tile_histogram;
layout(scalar, binding = 2) readonly buffer BucketTable { Bucket items[]; } bucket_table;
layout(scalar, binding = 4) writeonly buffer PixelList { uint items[]; } pixel_list;
layout(push_constant, scalar) uniform Push { BucketPush push; };

void main() {
    uint tile = gl_GlobalInvocationID.x;
    uint tiles = 1u << (push.tile_bits.x + push.tile_bits.y);
    if (tile >= tiles) return;
    uvec2 corner = tile_position(tile, push.tile_bits) * BUCKET_TILE;
    uvec2 end = min(corner + BUCKET_TILE, push.size);
    for (uint y = corner.y; y < end.y; ++y) {
        for (uint x = corner.x; x < end.x; ++x) {
            uint b = clamp(imageLoad(sample_count, ivec2(x, y)).x, 1u, push.bucket_count) - 1u;
            uint at = tile_histogram.items[b * tiles + tile]++;
            pixel_list.items[bucket_table.items[b].first + at] = x | y << 16;
        }
    }
}

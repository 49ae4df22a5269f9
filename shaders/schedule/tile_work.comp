// SPDX-License-Identifier: Apache-2.0
// reads sample_count; writes tile_work[tile]: samples that its pixels with k > 1 want.
// One invocation walks one tile.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "schedule/tile_list.h"

layout(local_size_x = 64) in;

layout(binding = 0, r8ui) uniform readonly uimage2D sample_count;
layout(scalar, binding = 1) writeonly buffer TileWork { uint items[]; } tile_work;
layout(push_constant, scalar) uniform Push { TileListPush push; };

void main() {
    uint tile = gl_GlobalInvocationID.x;
    if (tile >= 1u << (push.tile_bits.x + push.tile_bits.y)) return;
    uvec2 corner = tile_position(tile, push.tile_bits) * BUCKET_TILE;
    uvec2 end = min(corner + BUCKET_TILE, push.size);
    uint work = 0u;
    for (uint y = corner.y; y < end.y; ++y) {
        for (uint x = corner.x; x < end.x; ++x) {
            uint k = imageLoad(sample_count, ivec2(x, y)).x;
            work += k > 1u ? k : 0u;
        }
    }
    tile_work.items[tile] = work;
}

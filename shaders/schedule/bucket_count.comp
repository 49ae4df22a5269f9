// SPDX-License-Identifier: Apache-2.0
// reads sample_count; writes tile_histogram[bucket][tile]: items of each count in each tile.
// One invocation walks one tile, so no two write one word.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "schedule/buckets.h"

layout(local_size_x = 64) in;

layout(binding = 0, r8ui) uniform readonly uimage2D sample_count;
layout(scalar, binding = 1) writeonly buffer TileHistogram { uint items[]; } tile_histogram;
layout(push_constant, scalar) uniform Push { BucketPush push; };

void main() {
    uint tile = gl_GlobalInvocationID.x;
    uint tiles = 1u << (push.tile_bits.x + push.tile_bits.y);
    if (tile >= tiles) return;
    uint counts[MAX_BUCKETS];
    for (uint b = 0u; b < push.bucket_count; ++b) counts[b] = 0u;
    uvec2 corner = tile_position(tile, push.tile_bits) * BUCKET_TILE;
    uvec2 end = min(corner + BUCKET_TILE, push.size);
    for (uint y = corner.y; y < end.y; ++y) {
        for (uint x = corner.x; x < end.x; ++x) {
            ++counts[clamp(imageLoad(sample_count, ivec2(x, y)).x, 1u, push.bucket_count) - 1u];
        }
    }
    for (uint b = 0u; b < push.bucket_count; ++b) tile_histogram.items[b * tiles + tile] = counts[b];
}

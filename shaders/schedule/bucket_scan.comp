// SPDX-License-Identifier: Apache-2.0
// reads and writes tile_histogram: counts become exclusive prefix sums over the tiles of a bucket;
// writes bucket_table[b].count. One workgroup per bucket: a run of tiles per invocation, then a
// scan of the runs in shared memory.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "schedule/buckets.h"

layout(local_size_x = BUCKET_SCAN_WIDTH) in;

layout(scalar, binding = 1) buffer TileHistogram { uint items[]; } tile_histogram;
layout(scalar, binding = 2) writeonly buffer BucketTable { Bucket items[]; } bucket_table;
layout(push_constant, scalar) uniform Push { BucketPush push; };

shared uint run_sum[BUCKET_SCAN_WIDTH];

void main() {
    uint bucket = gl_WorkGroupID.x;
    uint lane = gl_LocalInvocationIndex;
    uint tiles = 1u << (push.tile_bits.x + push.tile_bits.y);
    uint run = (tiles + BUCKET_SCAN_WIDTH - 1u) / BUCKET_SCAN_WIDTH;
    uint first = min(lane * run, tiles);
    uint last = min(first + run, tiles);

    uint sum = 0u;
    for (uint t = first; t < last; ++t) sum += tile_histogram.items[bucket * tiles + t];
    run_sum[lane] = sum;
    barrier();
    for (uint stride = 1u; stride < BUCKET_SCAN_WIDTH; stride *= 2u) {
        uint below = lane >= stride ? run_sum[lane - stride] : 0u;
        barrier();
        run_sum[lane] += below;
        barrier();
    }
    uint before = run_sum[lane] - sum;
    for (uint t = first; t < last; ++t) {
        uint count = tile_histogram.items[bucket * tiles + t];
        tile_histogram.items[bucket * tiles + t] = before;
        before += count;
    }
    if (lane == BUCKET_SCAN_WIDTH - 1u) bucket_table.items[bucket].count = run_sum[lane];
}

// SPDX-License-Identifier: Apache-2.0
// reads tile_work; writes tile_list: the positions of tiles with work, in Morton order, and
// tile_arguments: one workgroup for each. One workgroup: a run of tiles per invocation, then a scan
// of the runs in shared memory. Groups beyond 65535 spread over two axes.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "schedule/tile_list.h"

layout(local_size_x = TILE_LIST_WIDTH) in;

layout(scalar, binding = 0) readonly buffer TileWork { uint items[]; } tile_work;
layout(scalar, binding = 1) writeonly buffer TileList { uint count; uint items[]; } tile_list;
layout(scalar, binding = 2) writeonly buffer TileArguments { DispatchArguments items[]; } tile_arguments;
layout(push_constant, scalar) uniform Push { TileListPush push; };

shared uint run_sum[TILE_LIST_WIDTH];

void main() {
    uint lane = gl_LocalInvocationIndex;
    uint tiles = 1u << (push.tile_bits.x + push.tile_bits.y);
    uint run = (tiles + TILE_LIST_WIDTH - 1u) / TILE_LIST_WIDTH;
    uint first = min(lane * run, tiles);
    uint last = min(first + run, tiles);

    uint sum = 0u;
    for (uint t = first; t < last; ++t) sum += tile_work.items[t] > 0u ? 1u : 0u;
    run_sum[lane] = sum;
    barrier();
    for (uint stride = 1u; stride < TILE_LIST_WIDTH; stride *= 2u) {
        uint below = lane >= stride ? run_sum[lane - stride] : 0u;
        barrier();
        run_sum[lane] += below;
        barrier();
    }
    uint at = run_sum[lane] - sum;
    for (uint t = first; t < last; ++t) {
        if (tile_work.items[t] == 0u) continue;
        uvec2 position = tile_position(t, push.tile_bits);
        tile_list.items[at++] = position.x | position.y << 16;
    }
    if (lane == TILE_LIST_WIDTH - 1u) {
        uint groups = run_sum[lane];
        uint rows = (groups + 65534u) / 65535u;
        tile_list.count = groups;
        tile_arguments.items[0].x = rows == 0u ? 0u : (groups + rows - 1u) / rows;
        tile_arguments.items[0].y = rows;
        tile_arguments.items[0].z = 1u;
    }
}

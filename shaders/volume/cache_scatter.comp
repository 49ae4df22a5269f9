// SPDX-License-Identifier: Apache-2.0
// reads scanned cache_runs; numbers the marked cells of cache_index in the order of the grid, so that
// slots follow from the volume alone. Cells beyond the capacity do without.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "volume/medium.glsl"
#include "volume/cache_geometry.glsl"

layout(local_size_x = 64) in;

layout(scalar, binding = 11) buffer CacheIndex { CacheHeader header; uint words[]; } cache_index;
layout(scalar, binding = 12) readonly buffer Runs { uvec2 items[]; } cache_runs;
layout(push_constant, scalar) uniform Push { CachePush push; };

void main() {
    uvec3 grid = cache_grid(push.scale);
    uint cells = grid.x * grid.y * grid.z;
    uint run = gl_GlobalInvocationID.y * gl_NumWorkGroups.x * 64u + gl_GlobalInvocationID.x;
    if (run >= (cells + CACHE_RUN - 1u) / CACHE_RUN) return;
    uint slot = cache_runs.items[run].x;
    uint end = min((run + 1u) * CACHE_RUN, cells);
    for (uint i = run * CACHE_RUN; i < end; ++i) {
        uint word = cache_index.words[i];
        if (word == CACHE_NONE) continue;
        cache_index.words[i] = slot < push.capacity ? word | slot : CACHE_NONE;
        ++slot;
    }
}

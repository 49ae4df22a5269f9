// SPDX-License-Identifier: Apache-2.0
// reads and writes cache_runs: counts become exclusive prefix sums; writes the header of cache_index.
// One workgroup: a stretch of runs per invocation, then a scan of the stretches in shared memory.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "volume/medium.glsl"
#include "volume/cache_geometry.glsl"

layout(local_size_x = CACHE_SCAN_WIDTH) in;

layout(scalar, binding = 11) buffer CacheIndex { CacheHeader header; uint words[]; } cache_index;
layout(scalar, binding = 12) buffer Runs { uvec2 items[]; } cache_runs;
layout(push_constant, scalar) uniform Push { CachePush push; };

shared uvec2 stretch_sum[CACHE_SCAN_WIDTH];

void main() {
    uint lane = gl_LocalInvocationIndex;
    uvec3 grid = cache_grid(push.scale);
    uint runs = (grid.x * grid.y * grid.z + CACHE_RUN - 1u) / CACHE_RUN;
    uint stretch = (runs + CACHE_SCAN_WIDTH - 1u) / CACHE_SCAN_WIDTH;
    uint first = min(lane * stretch, runs), last = min(first + stretch, runs);

    uvec2 sum = uvec2(0u);
    for (uint i = first; i < last; ++i) sum += cache_runs.items[i];
    stretch_sum[lane] = sum;
    barrier();
    for (uint stride = 1u; stride < CACHE_SCAN_WIDTH; stride *= 2u) {
        uvec2 below = lane >= stride ? stretch_sum[lane - stride] : uvec2(0u);
        barrier();
        stretch_sum[lane] += below;
        barrier();
    }
    uvec2 before = stretch_sum[lane] - sum;
    for (uint i = first; i < last; ++i) {
        uvec2 count = cache_runs.items[i];
        cache_runs.items[i] = before;
        before += count;
    }
    if (lane == CACHE_SCAN_WIDTH - 1u) {
        uvec2 total = stretch_sum[lane];
        uint words = push.format == CACHE_FP32 ? 3u : push.format == CACHE_FP16 ? 2u : 1u;
        cache_index.header = CacheHeader(grid, push.scale, push.format, push.directional,
            words + 2u * push.directional, total.x, total.y, push.occlusion);
    }
}

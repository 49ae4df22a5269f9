// SPDX-License-Identifier: Apache-2.0
// reads cache_sums and the round's goal; orders paths for the cells of the working set, and writes
// cache_counts, by which add_buckets() sorts them: 1 for none, then 1/8, 1/4, 1/2, 1 of push.paths.
//   urgency = (relative standard error / goal)^2 * contribution, where the error exceeds the goal
// The first paths double with each execution, so that there is some light everywhere soon.
// A cell gets new paths only once all that were ordered before have ended, and by its own sums alone,
// so that neither the loop budget nor other cells change what it gets.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "volume/medium.glsl"
#include "volume/cache_error.glsl"

layout(local_size_x = 64) in;

layout(scalar, binding = 10) readonly buffer Control { CacheControl data; } cache_control;
layout(scalar, binding = 11) buffer Sums { CacheSum items[]; } cache_sums;
layout(binding = 12, r8ui) uniform writeonly uimage2D cache_counts;
layout(push_constant, scalar) uniform Push { CachePush push; };

uint wanted(CacheSum sum) {
    if (sum.cell == CACHE_NONE) return 0u;
    if (sum.count < CACHE_TRUST_PATHS) return clamp(sum.count, push.paths / 8u, push.paths);
    float goal = cache_control.data.goal;
    if (cache_within(sum, goal)) return 0u;
    float bound = goal * cache_scale_of_error(sum);
    float excess = cache_squared_error(sum) * sum.contribution, unit = bound * bound;
    return excess >= 16.0 * unit ? push.paths
        : excess >= 4.0 * unit   ? push.paths / 2u
        : excess >= unit         ? push.paths / 4u
                                 : push.paths / 8u;
}

void main() {
    uint slot = gl_GlobalInvocationID.y * gl_NumWorkGroups.x * 64u + gl_GlobalInvocationID.x;
    ivec2 pixel = ivec2(slot % CACHE_SET_WIDTH, slot / CACHE_SET_WIDTH);
    if (pixel.y >= imageSize(cache_counts).y) return;
    uint owed = 0u;
    if (slot < push.set) {
        CacheSum sum = cache_sums.items[slot];
        owed = sum.owed == 0u ? wanted(sum) : sum.owed;
        cache_sums.items[slot].owed = owed;
    }
    uint eighths = (owed * 8u + push.paths - 1u) / push.paths; // 0 ... 8
    uint bucket = eighths == 0u ? 1u : uint(findMSB(2u * eighths - 1u)) + 2u;
    imageStore(cache_counts, pixel, uvec4(bucket, 0u, 0u, 0u));
}

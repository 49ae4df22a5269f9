// SPDX-License-Identifier: Apache-2.0
// reads cache_sums and the round's goal; orders paths for the cells of the working set, and writes
// cache_counts, by which add_buckets() sorts them: 1 for none, then 1/8, 1/4, 1/2, 1 of push.paths.
//   urgency = (relative standard error / goal)^2 * contribution
// The first paths double with each execution, so that there is some light everywhere soon. At 32, 64,
// 128 ... paths these judge how many the mean needs, and once that is near enough to be foreseen, the
// mean is of later paths alone: of paths that are asked whether they may be the last, bright ones that
// are alike say yes too soon. (Stein 1945, "A two-sample test for a linear hypothesis whose power is
// independent of the variance".)
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

uint wanted(inout CacheSum sum) {
    if (sum.cell == CACHE_NONE) return 0u;
    if (sum.due == 0u && sum.count < CACHE_TRUST_PATHS) return clamp(sum.count, push.paths / 8u, push.paths);
    float need = sum.due > 0u ? float(sum.due) : cache_need(sum, cache_control.data.goal);
    uint most = sum.due > 0u ? sum.due : 2u << findMSB(sum.count);
    if (sum.due == 0u && sum.count * 2u == most && need <= float(CACHE_TRUST_TIMES * sum.count)) {
        most = sum.due = max(uint(ceil(need)), sum.count);
        sum.least = sum.count;
        sum.count = 0u;
        sum.radiance = sum.flow = vec3(0.0);
        sum.square = 0.0;
    }
    float urgency = need / float(max(sum.count, 1u)) * sum.contribution;
    uint paths = urgency >= 16.0 ? push.paths
        : urgency >= 4.0         ? push.paths / 2u
        : urgency >= 1.0         ? push.paths / 4u
                                 : push.paths / 8u;
    return min(paths, most - min(sum.count, most));
}

void main() {
    uint slot = gl_GlobalInvocationID.y * gl_NumWorkGroups.x * 64u + gl_GlobalInvocationID.x;
    ivec2 pixel = ivec2(slot % CACHE_SET_WIDTH, slot / CACHE_SET_WIDTH);
    if (pixel.y >= imageSize(cache_counts).y) return;
    uint owed = 0u;
    if (slot < push.set) {
        CacheSum sum = cache_sums.items[slot];
        if (sum.owed == 0u) sum.owed = wanted(sum);
        cache_sums.items[slot] = sum;
        owed = sum.owed;
    }
    uint eighths = (owed * 8u + push.paths - 1u) / push.paths; // 0 ... 8
    uint bucket = eighths == 0u ? 1u : uint(findMSB(2u * eighths - 1u)) + 2u;
    imageStore(cache_counts, pixel, uvec4(bucket, 0u, 0u, 0u));
}

// SPDX-License-Identifier: Apache-2.0
// reads the G-buffer and who needs how many samples; writes the sum of each pixel's k samples.
// One of three defines says which pixels an invocation gets:
//   UNIFORM  every pixel, push.count samples each
//   LOOP     every pixel, as many as sample_count says        (the paper's plain loop)
//   BUCKETS  the pixels of one bucket, push.count samples each (one indirect dispatch per count)
// CONTINUE adds to the sums of an earlier dispatch.
// picks.glsl says which samples; the first one is reused from S, but at k = n all n are shaded anew
// with a footprint of one sample, which is full supersampling.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "schedule/buckets.h"
#include "surface/shade_sample.glsl"
#include "surface/picks.glsl"

#ifdef BUCKETS
layout(local_size_x = 64) in;
layout(scalar, binding = 10) readonly buffer BucketTable { Bucket items[]; } bucket_table;
layout(scalar, binding = 11) readonly buffer PixelList { uint items[]; } pixel_list;
#else
layout(local_size_x = 8, local_size_y = 8) in;
#endif
#ifdef LOOP
layout(binding = 12, r8ui) uniform readonly uimage2D sample_count;
#endif
#ifndef UNIFORM
layout(binding = 13, rgba32f) uniform readonly image2D first_sample;
#endif
#ifdef CONTINUE
layout(binding = 14, rgba32f) uniform image2D shaded_sum;
#else
layout(binding = 14, rgba32f) uniform writeonly image2D shaded_sum;
#endif

void main() {
    uint n = frame.data.m * frame.data.m;
#ifdef BUCKETS
    Bucket bucket = bucket_table.items[push.count - 1u];
    uint item = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 64u + gl_LocalInvocationIndex;
    if (item >= bucket.count) return;
    uint word = pixel_list.items[bucket.first + item];
    ivec2 pixel = ivec2(word & 0xffffu, word >> 16);
#else
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(frame.data.size)))) return;
#endif

#ifdef LOOP
    uint k = imageLoad(sample_count, pixel).x;
#else
    uint k = push.count;
#endif

    Picks picks = begin_picks(pixel, k);
    float weight, widening;
    uint first = push.first;
#ifdef CONTINUE
    vec4 sum = imageLoad(shaded_sum, pixel);
    for (uint i = 0u; i < first; ++i) next_pick(picks, weight, widening);
#else
    vec4 sum = vec4(0.0);
#endif
#ifndef UNIFORM
    if (k <= 1u) return;
    if (k < n && first == 0u) {
        next_pick(picks, weight, widening);
        sum = weight * imageLoad(first_sample, pixel);
        first = 1u;
    }
#endif
    uint last = min(min(push.last, k), first + push.loop_bound);
    for (uint i = first; i < last; ++i) {
        uint index = next_pick(picks, weight, widening);
        sum += weight * shade_sample(pixel, index, widening);
    }
    imageStore(shaded_sum, pixel, sum);
}

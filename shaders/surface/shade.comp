// SPDX-License-Identifier: Apache-2.0
// reads the G-buffer and who needs how many samples; writes the sum of each pixel's k samples.
// One of three defines says which pixel an invocation gets:
//   UNIFORM  every pixel, push.count samples each
//   LOOP     every pixel, as many as sample_count says        (the paper's plain loop)
//   LIST     those of count push.count in a list of all, or of 2 and more at n + 1, last first
// CONTINUE adds to the sums of an earlier dispatch.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "schedule/buckets.h"
#include "surface/shade_pixel.glsl"

#ifdef LIST
layout(local_size_x = BUCKET_GROUP) in;
layout(scalar, binding = 10) readonly buffer BucketTable { Bucket items[]; } bucket_table;
layout(scalar, binding = 11) readonly buffer PixelList { uint items[]; } pixel_list;
#else
layout(local_size_x = 8, local_size_y = 8) in;
#endif
#ifndef UNIFORM
layout(binding = 12, r8ui) uniform readonly uimage2D sample_count;
#endif

void main() {
#ifdef LIST
    Bucket range = bucket_table.items[push.count - 1u];
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint item = group * BUCKET_GROUP + gl_LocalInvocationIndex;
    if (item >= range.count) return;
    uint word = pixel_list.items[range.first + range.count - 1u - item];
    ivec2 pixel = ivec2(word & 0xffffu, word >> 16);
#else
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(frame.data.size)))) return;
#endif

#ifdef UNIFORM
    shade_pixel(pixel, push.count);
#else
    shade_pixel(pixel, imageLoad(sample_count, pixel).x);
#endif
}

// SPDX-License-Identifier: Apache-2.0
// Reads: newest, oldest. Writes: target = newest + oldest + value.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { uint value; } push;
layout(binding = 0) uniform usampler2D newest;
layout(binding = 1) uniform usampler2D oldest;
layout(binding = 2, r32ui) uniform writeonly uimage2D target;

void main() {
    const ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(target)))) return;
    const uint sum = texelFetch(newest, pixel, 0).r + texelFetch(oldest, pixel, 0).r;
    imageStore(target, pixel, uvec4(sum + push.value));
}

// SPDX-License-Identifier: Apache-2.0
// Reads: newest, oldest. Writes: target = newest + oldest + value.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.h"

layout(push_constant, scalar) uniform Push { uint value; } push;
layout(binding = 0) uniform usampler2D newest;
layout(binding = 1) uniform usampler2D oldest;
layout(location = 0) out uint target;

void main() {
    const ivec2 pixel = ivec2(gl_FragCoord.xy);
    target = texelFetch(newest, pixel, 0).r + texelFetch(oldest, pixel, 0).r + push.value;
}

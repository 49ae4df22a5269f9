// SPDX-License-Identifier: Apache-2.0
// Reads and writes: sums[i] += amount, total += amount (one texel).
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.h"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { uint amount; } push;
layout(binding = 0, scalar) buffer Sums { uint values[]; } sums;
layout(binding = 1, r32ui) uniform uimage2D total;

void main() {
    const uint i = gl_GlobalInvocationID.x;
    if (i < sums.values.length()) sums.values[i] += push.amount;
    if (i == 0) imageStore(total, ivec2(0), imageLoad(total, ivec2(0)) + push.amount);
}

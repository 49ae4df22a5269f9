// SPDX-License-Identifier: Apache-2.0
// Reads: newest, oldest. Writes: target[i] = newest[i] + oldest[i] + value + i.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.h"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { uint value; } push;
layout(binding = 0, scalar) readonly buffer Newest { uint values[]; } newest;
layout(binding = 1, scalar) readonly buffer Oldest { uint values[]; } oldest;
layout(binding = 2, scalar) writeonly buffer Target { uint values[]; } target;

void main() {
    const uint i = gl_GlobalInvocationID.x;
    if (i >= target.values.length()) return;
    target.values[i] = newest.values[i] + oldest.values[i] + push.value + i;
}

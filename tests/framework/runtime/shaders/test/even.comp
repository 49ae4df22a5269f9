// SPDX-License-Identifier: Apache-2.0
// Writes: numbers[i] = i where i is even, and leaves the others as they are.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.h"

layout(local_size_x = 64) in;
layout(binding = 0, scalar) writeonly buffer Numbers { uint values[]; } numbers;

void main() {
    const uint i = gl_GlobalInvocationID.x;
    if (i % 2 == 0 && i < numbers.values.length()) numbers.values[i] = i;
}

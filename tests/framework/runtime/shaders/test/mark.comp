// SPDX-License-Identifier: Apache-2.0
// Reads and writes: marks[i] += value.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.h"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { uint value; } push;
layout(binding = 0, scalar) buffer Marks { uint values[]; } marks;

void main() {
    const uint i = gl_GlobalInvocationID.x;
    if (i < marks.values.length()) marks.values[i] += push.value;
}

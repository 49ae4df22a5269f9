// SPDX-License-Identifier: Apache-2.0
// More push constants than the portable budget.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.h"

layout(local_size_x = 8) in;
layout(push_constant, scalar) uniform Push { vec4 values[9]; } push;
layout(binding = 0, scalar) writeonly buffer Numbers { float values[]; } numbers;

void main() { numbers.values[gl_GlobalInvocationID.x] = push.values[8].x; }

// SPDX-License-Identifier: Apache-2.0
// Too large a workgroup for the portable budget.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.h"

layout(local_size_x_id = 1, local_size_y = 8) in;
layout(binding = 0, scalar) writeonly buffer Numbers { uint values[]; } numbers;

void main() { numbers.values[gl_LocalInvocationIndex] = gl_LocalInvocationIndex; }

// SPDX-License-Identifier: Apache-2.0
// Writes: numbers[i] = i * factor + offset.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.h"

layout(constant_id = 0) const uint factor = 1;
layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { uint count; uint offset; } push;
layout(binding = 0, scalar) writeonly buffer Numbers { uint values[]; } numbers;

void main() {
    const uint i = gl_GlobalInvocationID.x;
    if (i < push.count) numbers.values[i] = i * factor + push.offset;
}

// SPDX-License-Identifier: Apache-2.0
// Reads: source. Writes: target[i] = source[i] + 1.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.h"

layout(local_size_x = 64) in;
layout(binding = 0, scalar) readonly buffer Source { uint values[]; } source;
layout(binding = 1, scalar) writeonly buffer Target { uint values[]; } target;

void main() {
    const uint i = gl_GlobalInvocationID.x;
    if (i < target.values.length()) target.values[i] = source.values[i] + 1;
}

// SPDX-License-Identifier: Apache-2.0
// Reads: source in set 0, table in set 2. Writes: target in set 0.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.h"

layout(local_size_x = 64) in;
layout(set = 0, binding = 0, scalar) readonly buffer Source { uint values[]; } source;
layout(set = 0, binding = 3, scalar) writeonly buffer Target { uint values[]; } target;
layout(set = 2, binding = 1, scalar) uniform Table { uint bias; } table;

void main() {
    const uint i = gl_GlobalInvocationID.x;
    if (i < target.values.length()) target.values[i] = source.values[i] + table.bias;
}

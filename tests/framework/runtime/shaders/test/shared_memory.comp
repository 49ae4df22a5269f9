// SPDX-License-Identifier: Apache-2.0
// All of the portable budget of 32 KiB of shared variables; with TOO_MUCH, 48.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.h"

#ifdef TOO_MUCH
const uint kRows = 2;
#else
const uint kRows = 1;
#endif

struct Cell {
    vec3 position;
    uint count;
};

layout(local_size_x = 8) in;
layout(binding = 0, scalar) writeonly buffer Numbers { uint values[]; } numbers;
shared Cell cells[1024];         // 16 KiB
shared vec4 rows[kRows][1024];   // 16 KiB each

void main() {
    const uint i = gl_LocalInvocationIndex;
    cells[i].count = i;
    rows[kRows - 1][i] = vec4(i);
    barrier();
    numbers.values[i] = cells[7 - i].count + uint(rows[kRows - 1][7 - i].x);
}

// SPDX-License-Identifier: Apache-2.0
// Reads: picture. Writes: row_sums, one sum per row.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.h"

layout(local_size_x = 64) in;
layout(binding = 0) uniform sampler2D picture;
layout(binding = 1, scalar) writeonly buffer RowSums { float values[]; } row_sums;

void main() {
    const ivec2 size = textureSize(picture, 0);
    const int row = int(gl_GlobalInvocationID.x);
    if (row >= size.y) return;
    float sum = 0.0;
    for (int x = 0; x < size.x; ++x) sum += texelFetch(picture, ivec2(x, row), 0).r;
    row_sums.values[row] = sum;
}

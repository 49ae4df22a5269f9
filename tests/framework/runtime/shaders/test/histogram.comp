// SPDX-License-Identifier: Apache-2.0
// Reads: ids. Writes: counts[id] by atomics.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform usampler2D ids;
layout(binding = 1, scalar) buffer Counts { uint values[]; } counts;

void main() {
    const ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, textureSize(ids, 0)))) return;
    atomicAdd(counts.values[texelFetch(ids, pixel, 0).r], 1);
}

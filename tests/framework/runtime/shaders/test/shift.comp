// SPDX-License-Identifier: Apache-2.0
// Reads: source, sampled. Writes: target = 2 source + 1.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform sampler2D source;
layout(binding = 1, r32f) uniform writeonly image2D target;

void main() {
    const ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(target)))) return;
    imageStore(target, pixel, 2.0 * texelFetch(source, pixel, 0) + 1.0);
}

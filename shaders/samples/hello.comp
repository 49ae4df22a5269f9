// SPDX-License-Identifier: Apache-2.0
// Writes: picture, a circle of radius 0.4 heights in the middle: 1 inside, 0 outside.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, r32f) uniform writeonly image2D picture;

void main() {
    const ivec2 size = imageSize(picture);
    const ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, size))) return;
    const vec2 center = (vec2(pixel) + 0.5 - 0.5 * vec2(size)) / float(size.y);
    imageStore(picture, pixel, vec4(length(center) < 0.4 ? 1.0 : 0.0));
}

// SPDX-License-Identifier: Apache-2.0
// Writes: target(x, y) = x + 100 y + offset.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { float offset; } push;
layout(binding = 0, r32f) uniform writeonly image2D target;

void main() {
    const ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(target)))) return;
    imageStore(target, pixel, vec4(float(pixel.x) + 100.0 * float(pixel.y) + push.offset));
}

// SPDX-License-Identifier: Apache-2.0
// Reads: drawn. Writes: tinted, the tint times what was drawn, or with INVERTED times 1 minus it.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "consumer/tint.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { Tint tint; };
layout(binding = 0) uniform sampler2D drawn;
layout(binding = 1, rgba32f) uniform writeonly image2D tinted;

void main() {
    const ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(tinted)))) return;
    vec3 color = texelFetch(drawn, pixel, 0).rgb;
#ifdef INVERTED
    color = 1 - color;
#endif
    imageStore(tinted, pixel, vec4(tint.color * color, tint.alpha));
}

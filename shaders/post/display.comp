// SPDX-License-Identifier: Apache-2.0
// reads linear radiance; writes what a display shows of it, sRGB-encoded and clamped, and its luma.
//   out = (srgb(r), srgb(g), srgb(b), Rec. 709 luma of the three)
#version 460
#extension GL_GOOGLE_include_directive : require

#include "include/color.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0) uniform sampler2D radiance;
layout(binding = 1, rgba16f) uniform writeonly image2D display;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(display)))) return;
    vec3 encoded = srgb_encode(texelFetch(radiance, pixel, 0).rgb);
    imageStore(display, pixel, vec4(encoded, dot(encoded, vec3(0.2126, 0.7152, 0.0722))));
}

// SPDX-License-Identifier: Apache-2.0
// reads S; writes its Rec. 709 luma, display-encoded, NaN and beyond as black. The metric asks for that
// of up to 28 neighbours a pixel, and powers are dear.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "include/color.glsl"
#include "surface/metrics.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0) uniform sampler2D first_sample;
layout(binding = 1, r32f) uniform writeonly image2D first_luma;
layout(push_constant, scalar) uniform Push { PictureSizePush push; };

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(push.size)))) return;
    float y = luma(texelFetch(first_sample, pixel, 0).rgb);
    imageStore(first_luma, pixel, vec4(y >= 0.0 ? y : 0.0));
}

// SPDX-License-Identifier: Apache-2.0
// reads the luma of the displayed picture; writes which pixels differ from those left and above.
//   edge = |l - l'| >= threshold, and 2 |l - l'| >= every step nearby (local contrast adaptation)
// Jimenez et al., SMAA: Enhanced Subpixel Morphological Antialiasing, Eurographics 2012, section 3.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "post/smaa.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0) uniform sampler2D display;
layout(binding = 1, r8ui) uniform writeonly uimage2D edges;
layout(push_constant, scalar) uniform Push { SmaaPush push; };

float luma_at(ivec2 position) {
    return texelFetch(display, clamp(position, ivec2(0), textureSize(display, 0) - 1), 0).a;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, textureSize(display, 0)))) return;
    float l = luma_at(pixel);
    float left = luma_at(pixel - ivec2(1, 0)), top = luma_at(pixel - ivec2(0, 1));
    vec2 step_here = abs(l - vec2(left, top));
    vec2 step_after = abs(l - vec2(luma_at(pixel + ivec2(1, 0)), luma_at(pixel + ivec2(0, 1))));
    vec2 step_before = abs(vec2(left, top) - vec2(luma_at(pixel - ivec2(2, 0)), luma_at(pixel - ivec2(0, 2))));
    vec2 largest = max(step_here, max(step_after, step_before));
    float limit = max(2.0 * push.threshold, max(largest.x, largest.y));
    bvec2 edge = greaterThanEqual(2.0 * step_here, vec2(limit));
    imageStore(edges, pixel, uvec4((edge.x ? SMAA_EDGE_LEFT : 0u) | (edge.y ? SMAA_EDGE_TOP : 0u)));
}

// SPDX-License-Identifier: Apache-2.0
// reads variance; writes k by the law of variance.glsl for one lambda.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "surface/allocate.h"
#include "surface/metrics.h"
#include "surface/variance.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0, rg32f) uniform readonly image2D variance;
layout(binding = 1, r8ui) uniform writeonly uimage2D sample_count;
#ifdef WINNER
layout(binding = 2, r8ui) uniform writeonly uimage2D winner;
#endif
layout(push_constant, scalar) uniform Push { AllocatePush push; };

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(push.size)))) return;
    vec2 expected = imageLoad(variance, pixel).xy;
    uint k = allocated_samples(expected, push.lambda, push.samples);
    imageStore(sample_count, pixel, uvec4(k));
#ifdef WINNER
    bool surfaces = k == surface_count(expected) && expected.y >= push.lambda;
    imageStore(winner, pixel, uvec4(k <= 1u ? WINNER_NONE : surfaces ? WINNER_SURFACES : WINNER_VARIATION));
#endif
}

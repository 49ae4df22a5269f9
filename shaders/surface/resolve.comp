// SPDX-License-Identifier: Apache-2.0
// reads the sums of shaded samples (and S, k); writes the picture: the plain mean of k samples.
// Linear, unclamped radiance; alpha is the share of shaded samples that hit a surface.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "surface/resolve.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0, rgba32f) uniform readonly image2D shaded_sum;
#ifndef UNIFORM
layout(binding = 1, rgba32f) uniform readonly image2D first_sample;
layout(binding = 2, r8ui) uniform readonly uimage2D sample_count;
#endif
layout(binding = 3, rgba32f) uniform writeonly image2D radiance;
layout(push_constant, scalar) uniform Push { ResolvePush push; };

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(push.size)))) return;
#ifdef UNIFORM
    vec4 mean = imageLoad(shaded_sum, pixel) / float(push.count);
#else
    uint k = imageLoad(sample_count, pixel).x;
    vec4 mean = k <= 1u ? imageLoad(first_sample, pixel) : imageLoad(shaded_sum, pixel) / float(k);
#endif
    imageStore(radiance, pixel, mean);
}

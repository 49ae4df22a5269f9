// SPDX-License-Identifier: Apache-2.0
// reads a picture, and what to blur along one axis; writes the picture with a share of the blur.
//   target = (1 - share) sharp + share sum_i w_i source(pixel + i axis),  w_i ~ exp(-i^2 / 2 sigma^2)
// A Gaussian is the product of one along rows and one along columns.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "post/bloom.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0) uniform sampler2D sharp;
layout(binding = 1) uniform sampler2D source;
layout(binding = 2, rgba32f) uniform writeonly image2D target;
layout(push_constant, scalar) uniform Push { BloomPush push; };

vec3 light(ivec2 pixel, ivec2 size) {
    return texelFetch(source, clamp(pixel, ivec2(0), size - 1), 0).rgb;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(target);
    if (any(greaterThanEqual(pixel, size))) return;

    vec3 sum = light(pixel, size);
    float weights = 1.0;
    for (int i = 1; i <= push.radius; ++i) {
        float distance = float(i) / push.sigma;
        float weight = exp(-0.5 * distance * distance);
        sum += weight * (light(pixel + i * push.axis, size) + light(pixel - i * push.axis, size));
        weights += 2.0 * weight;
    }
    vec4 own = texelFetch(sharp, pixel, 0);
    imageStore(target, pixel, vec4(mix(own.rgb, sum / weights, push.share), own.a));
}

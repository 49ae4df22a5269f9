// SPDX-License-Identifier: Apache-2.0
// reads expected variance; writes it again with each pixel's x drawn towards what its neighbours
// expect:
//   x' = cbrt(x^2 mean(x))      mean: over 3 x 3 pixels
// One difference of first samples says little about a pixel; eight more say how rough it is there.
// Where nothing varies nothing will: 0 stays 0.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "surface/metrics.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0, rg32f) uniform readonly image2D lone_variance;
layout(binding = 1, rg32f) uniform writeonly image2D variance;
layout(push_constant, scalar) uniform Push { PictureSizePush push; };

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), last = ivec2(push.size) - 1;
    if (any(greaterThan(pixel, last))) return;
    vec2 own = imageLoad(lone_variance, pixel).xy;
    float sum = 0.0;
    for (int y = -1; y <= 1; ++y) {
        for (int x = -1; x <= 1; ++x) sum += imageLoad(lone_variance, clamp(pixel + ivec2(x, y), ivec2(0), last)).x;
    }
    // Drivers may compute pow() by logarithms, of which 0 has none.
    float pooled = own.x > 0.0 ? pow(own.x * own.x * sum / 9.0, 1.0 / 3.0) : 0.0;
    imageStore(variance, pixel, vec4(pooled, own.y, 0.0, 0.0));
}

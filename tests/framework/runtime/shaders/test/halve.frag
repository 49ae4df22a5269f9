// SPDX-License-Identifier: Apache-2.0
// Reads: source, the mip above. Writes: target = sum of the 2 x 2 texels of source, fewer at odd
// edges.
#version 460

layout(binding = 0) uniform sampler2D source;
layout(location = 0) out float target;

void main() {
    const ivec2 size = textureSize(source, 0);
    target = 0.0;
    for (int i = 0; i < 4; ++i) {
        const ivec2 texel = 2 * ivec2(gl_FragCoord.xy) + ivec2(i & 1, i >> 1);
        if (all(lessThan(texel, size))) target += texelFetch(source, texel, 0).r;
    }
}

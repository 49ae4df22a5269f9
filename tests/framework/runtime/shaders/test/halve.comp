// SPDX-License-Identifier: Apache-2.0
// Reads: source, the mip above. Writes: target = sum of the 2 x 2 texels of source, fewer at odd
// edges.
#version 460

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform sampler2D source;
layout(binding = 1, r32f) uniform writeonly image2D target;

void main() {
    const ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(target)))) return;
    const ivec2 size = textureSize(source, 0);
    float sum = 0.0;
    for (int i = 0; i < 4; ++i) {
        const ivec2 texel = 2 * pixel + ivec2(i & 1, i >> 1);
        if (all(lessThan(texel, size))) sum += texelFetch(source, texel, 0).r;
    }
    imageStore(target, pixel, vec4(sum));
}

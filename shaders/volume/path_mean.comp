// SPDX-License-Identifier: Apache-2.0
// reads sums and how many samples each pixel has finished; writes the picture: their mean.
// Linear, unclamped radiance; alpha is the share of samples that met anything.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0, rgba32f) uniform readonly image2D sum;
layout(scalar, binding = 1) readonly buffer Progress { uvec2 pixels[]; } progress; // finished, wanted
layout(binding = 2, rgba32f) uniform writeonly image2D radiance;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(radiance);
    if (any(greaterThanEqual(pixel, size))) return;
    float count = float(progress.pixels[pixel.y * size.x + pixel.x].x);
    imageStore(radiance, pixel, count > 0.0 ? imageLoad(sum, pixel) / count : vec4(0.0));
}

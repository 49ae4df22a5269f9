// SPDX-License-Identifier: Apache-2.0
// reads the G-buffer; writes S: the first sample of each pixel, shaded for the whole pixel.
// Hollaender et al. 2013, section 3. STRATIFIED: for all of its surface in the window (`clusters`),
// whose means it shows.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "surface/shade_sample.glsl"
#ifdef STRATIFIED
#include "surface/clusters.glsl"
#include "surface/surface_means.glsl"
layout(binding = 15) uniform usampler2D clusters;
#endif

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 9, rgba32f) uniform writeonly image2D first_sample;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(frame.data.size)))) return;
    Pick pick = Pick(frame.data.order[0], 1.0, float(frame.data.m), 0.0, 0u);
#ifdef STRATIFIED
    uint n = frame.data.m * frame.data.m;
    uvec4 words = texelFetch(clusters, pixel, 0);
    uint size = cluster_sizes(n <= 16u ? uvec4(words.x, 0u, 0u, 0u) : words, n).x;
    pick.widening = sqrt(float(size));
    uvec4 means = texelFetch(surface_means, pixel, 0);
    pick.albedo = mean_albedo(means, 0u);
    pick.roughening = roughening(means, 1.0);
#endif
    imageStore(first_sample, pixel, shade_sample(pixel, pick));
}

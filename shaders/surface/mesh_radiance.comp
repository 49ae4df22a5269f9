// SPDX-License-Identifier: Apache-2.0
// reads the G-buffer, the surfaces of each window and the meshes' picture; writes the radiance of
// each of these surfaces, a layer each, such that their mean by coverage is the picture:
//   L_i = l_i + L - sum of coverage_j l_j,    l_i: the surface's first sample, shaded
// and, of windows that see one surface, the picture. Alpha: share that hits a surface.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "surface/shade_sample.glsl"
#include "surface/clusters.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 13, rgba32f) uniform readonly image2D meshes;
layout(binding = 14, rgba32f) uniform writeonly image2DArray mesh_radiance;
layout(binding = 15) uniform usampler2D clusters;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(frame.data.size)))) return;
    uint n = frame.data.m * frame.data.m;
    uvec4 words = texelFetch(clusters, pixel, 0);
    uvec4 labels = n <= 16u ? uvec4(words.x, 0u, 0u, 0u) : words;
    uvec4 sizes = cluster_sizes(labels, n);
    uint count = sizes.x == n ? 0u : cluster_count(sizes); // loops of no turn where there is one
    vec4 rest = imageLoad(meshes, pixel), colors[MAX_CLUSTERS];
    for (uint label = 0u; label < count; ++label) {
        uint index = frame.data.order[cluster_first_rank(labels, label)];
        colors[label] = shade_sample(pixel, Pick(index, 1.0, sqrt(float(sizes[label])), 0.0, 0u));
        rest -= float(sizes[label]) / float(n) * colors[label];
    }
    if (count == 0u) imageStore(mesh_radiance, ivec3(pixel, 0), rest);
    for (uint label = 0u; label < count; ++label)
        imageStore(mesh_radiance, ivec3(pixel, label), colors[label] + rest);
}

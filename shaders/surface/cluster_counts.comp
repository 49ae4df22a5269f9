// SPDX-License-Identifier: Apache-2.0
// reads clusters; writes k by the number of surfaces that a pixel sees and nothing else.
//   k = single where there is one, else several, or the number of surfaces
// Several: MSAA with per-sample edges (all n); number: one shade per surface, as Salvi and Vidimce,
// Surface Based Anti-Aliasing, I3D 2012.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "surface/cluster_counts.h"
#include "surface/clusters.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0) uniform usampler2D clusters;
layout(binding = 1, r8ui) uniform writeonly uimage2D sample_count;
layout(push_constant, scalar) uniform Push { ClusterCountsPush push; };

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, textureSize(clusters, 0)))) return;
    uvec4 labels = texelFetch(clusters, pixel, 0);
    if (push.samples <= 16u) labels.yzw = uvec3(0u); // one word; others read as 0, 0, 1
    uint surfaces = cluster_count(cluster_sizes(labels, push.samples));
    uint several = push.several > 0u ? push.several : surfaces;
    imageStore(sample_count, pixel, uvec4(surfaces == 1u ? push.single : several));
}

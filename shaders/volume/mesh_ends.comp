// SPDX-License-Identifier: Apache-2.0
// reads the depth of the G-buffer (LABELS: and the surfaces of each window); writes, for each of its
// samples, how far along the camera's ray a mesh or an opaque isosurface is met, and which surface of
// its window that is:
//   distance = view depth * length(forward + across)      (orthographic: view depth)
// in world units, kInfinity where none is met; its bits, the last two of them the label.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "shared/frame.h"

layout(scalar, binding = 0) uniform Frame { FrameData data; } frame;
#include "surface/surface_sample.glsl"
#ifdef LABELS
#include "surface/clusters.glsl"
layout(binding = 15) uniform usampler2D clusters;
#endif

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 14, r32ui) uniform writeonly uimage2D mesh_ends;

const float kInfinity = 1e30;

/// An invocation takes a sample of the order, not of the window: labels are kept by rank.
void main() {
    int m = int(frame.data.m);
    ivec2 item = ivec2(gl_GlobalInvocationID.xy), pixel = item / m, at = item - pixel * m;
    if (any(greaterThanEqual(pixel, ivec2(frame.data.size)))) return;
    uint rank = uint(at.y * m + at.x), label = 0u;
    ivec2 position = pixel * m + window_offset(int(frame.data.order[rank]));
#ifdef LABELS
    uvec4 words = texelFetch(clusters, pixel, 0);
    label = cluster_label(m <= 4 ? uvec4(words.x, 0u, 0u, 0u) : words, rank);
#endif
    float depth = fetch_depth(position);
    vec3 way = frame.data.forward + sample_across(position);
    float lengthening = frame.data.orthographic != 0u ? 1.0 : length(way);
    float distance = depth > 0.0 ? view_depth(depth) * lengthening : kInfinity;
    imageStore(mesh_ends, item, uvec4(floatBitsToUint(distance) & ~3u | label));
}

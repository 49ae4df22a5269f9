// SPDX-License-Identifier: Apache-2.0
// reads rays; writes where search_meshes() says that each meets a triangle (kFar: nowhere), the row of
// that triangle, and the calls that it took.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "include/random.glsl"
#include "volume/mesh_tree.glsl"

layout(local_size_x = 64) in;

layout(scalar, binding = 10) readonly buffer Rays { vec3 of[]; } rays; // origin, direction
layout(scalar, binding = 11) writeonly buffer Hits { uvec3 of[]; } hits;

const float kFar = 1e30;

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (2u * i >= rays.of.length()) return;
    MeshSearch search = begin_mesh_search(kFar);
    uint calls = 0u;
    bool ended = false;
    while (!ended && calls < 1000u) {
        ended = search_meshes(search, rays.of[2u * i], rays.of[2u * i + 1u], uvec4(i, 1u, 2u, 3u), false);
        ++calls;
    }
    hits.of[i] = uvec3(floatBitsToUint(search.t), search.triangle, calls);
}

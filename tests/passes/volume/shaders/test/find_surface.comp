// SPDX-License-Identifier: Apache-2.0
// reads rays; writes what find_surface() says of each, called as often as its budget asks for.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "volume/medium.glsl"
#include "volume/surface.glsl"
#include "test/find_surface.h"

layout(local_size_x = 64) in;

layout(scalar, binding = 10) readonly buffer Rays { FindSurfaceRay of[]; } rays;
layout(scalar, binding = 11) writeonly buffer Hits { FindSurfaceHit of[]; } hits;
layout(push_constant, scalar) uniform Push { FindSurfacePush push; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    FindSurfaceRay ray = rays.of[i];
    float from = ray.t0;
    bool start_solid = ray.start_solid != 0u, found = false;
    SurfaceHit hit;
    uint calls = 0u;
    do {
        uint budget = push.budget;
        found = find_surface(ray.origin, ray.direction, from, ray.t1, start_solid, ray.entry_normal, budget, hit);
        from = hit.t;
        start_solid = false;
        ++calls;
    } while (!found && hit.t < ray.t1 && calls < 4096u);
    hits.of[i] = FindSurfaceHit(hit.t, hit.surface, hit.normal, hit.cut ? 1u : 0u, found ? 1u : 0u, calls);
}

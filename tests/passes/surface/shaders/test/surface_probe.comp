// SPDX-License-Identifier: Apache-2.0
// reads a G-buffer; writes what surface_sample.glsl makes of each of its samples, row by row.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "shared/frame.h"
#include "test/surface_probe.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(scalar, binding = 0) uniform Frame { FrameData data; } frame;
#include "surface/surface_sample.glsl"
layout(scalar, binding = 10) writeonly buffer Probes { SurfaceProbe of[]; } probes;

void main() {
    ivec2 position = ivec2(gl_GlobalInvocationID.xy);
    ivec2 extent = ivec2(frame.data.size * frame.data.m);
    if (any(greaterThanEqual(position, extent))) return;
    SurfaceSample s = fetch_surface(position);
    SurfaceProbe p;
    p.depth = s.depth;
    p.material = s.material;
    p.normal = s.normal;
    p.color = s.color;
    for (int i = 0; i < 2; ++i) {
        p.uv[i] = s.coordinates[i].uv;
        p.gradient_x[i] = s.coordinates[i].gradient_x;
        p.gradient_y[i] = s.coordinates[i].gradient_y;
    }
    SurfacePlane plane = fetch_plane(position);
    p.slope = plane.slope;
    p.plane_normal = plane_normal(position, plane);
    bool last_x = position.x == extent.x - 1, last_y = position.y == extent.y - 1;
    p.breaks = (last_x || discontinuous(position, s, ivec2(1, 0)) ? 1u : 0u) |
               (last_y || discontinuous(position, s, ivec2(0, 1)) ? 2u : 0u);
    probes.of[position.y * extent.x + position.x] = p;
}

// SPDX-License-Identifier: Apache-2.0
// reads vertices, instances, frame; writes the position seen from the sun, and what an alpha test
// needs.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "shared/frame.h"
#include "surface/vertex.glsl"

layout(scalar, binding = 0) uniform Frame { FrameData data; } frame;

layout(location = 0) out vec2 out_uv0;
layout(location = 1) out vec2 out_uv1;
layout(location = 2) out float out_alpha;

void main() {
    InstanceData instance = instances.items[gl_InstanceIndex];
    uint base = uint(gl_VertexIndex) * kVertexStride;
    Vertex vertex = fetch_vertex(base);
    gl_Position = frame.data.sun_projection * vec4(to_world(instance, vertex.position), 1.0);
    out_uv0 = vertex.uv0;
    out_uv1 = fetch_uv1(base);
    out_alpha = fetch_color(base).a;
}

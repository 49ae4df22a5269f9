// SPDX-License-Identifier: Apache-2.0
// reads vertices, instances, frame; writes clip position and attributes in world space.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "shared/frame.h"
#include "surface/vertex.glsl"

layout(scalar, binding = 0) uniform Frame { FrameData data; } frame;

layout(location = 0) out vec3 out_normal;
layout(location = 1) out vec4 out_tangent;
layout(location = 2) out vec2 out_uv0;
layout(location = 3) out vec2 out_uv1;
layout(location = 4) out vec4 out_color;

void main() {
    InstanceData instance = instances.items[gl_InstanceIndex];
    uint base = uint(gl_VertexIndex) * kVertexStride;
    Vertex vertex = fetch_vertex(base);
    gl_Position = frame.data.view_projection * vec4(to_world(instance, vertex.position), 1.0);
    out_normal = normalize(to_world_normal(instance, vertex.normal));
    out_tangent = fetch_tangent(instance, base);
    out_uv0 = vertex.uv0;
    out_uv1 = fetch_uv1(base);
    out_color = fetch_color(base);
}

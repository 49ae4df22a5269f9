// SPDX-License-Identifier: Apache-2.0
// reads vertices, instances, frame; writes clip position and attributes in world space.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "shared/frame.h"
#include "surface/vertex.glsl"

layout(scalar, binding = 0) readonly buffer Frame { FrameData data; } frame;

layout(location = 0) out vec3 out_normal;
layout(location = 1) out vec4 out_tangent;
layout(location = 2) out vec2 out_uv0;
layout(location = 3) out vec2 out_uv1;
layout(location = 4) out vec4 out_color;

void main() {
    InstanceData instance = instances.items[gl_InstanceIndex];
    uint base = uint(gl_VertexIndex) * kVertexStride;
    gl_Position = frame.data.view_projection * vec4(to_world(instance, vertex_vec3(base)), 1.0);
    out_normal = vertex_normal(instance, base);
    out_tangent = vertex_tangent(instance, base);
    out_uv0 = vertex_uv(base, 0);
    out_uv1 = vertex_uv(base, 1);
    out_color = vertex_color(base);
}

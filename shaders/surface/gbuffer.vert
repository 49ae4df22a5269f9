// SPDX-License-Identifier: Apache-2.0
// reads vertices, instances, frame; writes clip position and attributes in world space.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "surface/vertex.glsl"

layout(location = 0) out vec3 out_normal;
layout(location = 1) out vec4 out_tangent;
layout(location = 2) out vec2 out_uv0;
layout(location = 3) out vec2 out_uv1;
layout(location = 4) out vec4 out_color;

void main() {
    InstanceData instance = instances.items[gl_InstanceIndex];
    uint base = uint(gl_VertexIndex) * kVertexStride;
    vec3 world = to_world(instance, vertex_vec3(base));
    gl_Position = frame.data.view_projection * vec4(world, 1.0);
    out_normal = normalize(to_world_normal(instance, vertex_vec3(base + kNormalOffset)));
    out_tangent = vec4(0.0);
    if (kTangentOffset != ATTRIBUTE_ABSENT) {
        vec4 tangent = vertex_vec4(base + kTangentOffset);
        out_tangent = vec4(to_world_tangent(instance, tangent.xyz), tangent.w * handedness(instance));
    }
    out_uv0 = kUv0Offset == ATTRIBUTE_ABSENT ? vec2(0.0) : vertex_vec2(base + kUv0Offset);
    out_uv1 = kUv1Offset == ATTRIBUTE_ABSENT ? vec2(0.0) : vertex_vec2(base + kUv1Offset);
    out_color = kColorOffset == ATTRIBUTE_ABSENT ? vec4(1.0) : vertex_vec4(base + kColorOffset);
}

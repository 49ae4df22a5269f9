// SPDX-License-Identifier: Apache-2.0
// Vertices and instances pulled from storage buffers: by vertex shaders, and by whoever evaluates a
// triangle anew (visibility.glsl).

#include "shared/scene.h"
#include "surface/gbuffer.h"

layout(constant_id = SPEC_VERTEX_STRIDE) const uint kVertexStride = 6;
layout(constant_id = SPEC_NORMAL_OFFSET) const uint kNormalOffset = 3;
layout(constant_id = SPEC_TANGENT_OFFSET) const uint kTangentOffset = ATTRIBUTE_ABSENT;
layout(constant_id = SPEC_UV0_OFFSET) const uint kUv0Offset = ATTRIBUTE_ABSENT;
layout(constant_id = SPEC_UV1_OFFSET) const uint kUv1Offset = ATTRIBUTE_ABSENT;
layout(constant_id = SPEC_COLOR_OFFSET) const uint kColorOffset = ATTRIBUTE_ABSENT;

layout(scalar, binding = 20) readonly buffer Vertices { float values[]; } vertices;
layout(scalar, binding = 21) readonly buffer Instances { InstanceData items[]; } instances;

vec2 vertex_vec2(uint at) { return vec2(vertices.values[at], vertices.values[at + 1]); }
vec3 vertex_vec3(uint at) { return vec3(vertex_vec2(at), vertices.values[at + 2]); }
vec4 vertex_vec4(uint at) { return vec4(vertex_vec3(at), vertices.values[at + 3]); }

vec3 to_world(InstanceData instance, vec3 position) {
    vec4 p = vec4(position, 1.0);
    return vec3(dot(instance.world_x, p), dot(instance.world_y, p), dot(instance.world_z, p));
}

/// Directions in the surface.
vec3 to_world_tangent(InstanceData instance, vec3 v) {
    return vec3(dot(instance.world_x.xyz, v), dot(instance.world_y.xyz, v), dot(instance.world_z.xyz, v));
}

/// -1 where the instance mirrors, else 1.
float handedness(InstanceData instance) {
    return dot(instance.world_x.xyz, cross(instance.world_y.xyz, instance.world_z.xyz)) < 0.0 ? -1.0 : 1.0;
}

/// Normals: cofactors of the linear part, with the sign that keeps them outward when mirrored.
vec3 to_world_normal(InstanceData instance, vec3 v) {
    vec3 x = instance.world_x.xyz, y = instance.world_y.xyz, z = instance.world_z.xyz;
    vec3 n = vec3(dot(cross(y, z), v), dot(cross(z, x), v), dot(cross(x, y), v));
    return n * handedness(instance);
}

vec2 vertex_uv(uint base, int set) {
    uint offset = set == 0 ? kUv0Offset : kUv1Offset;
    return offset == ATTRIBUTE_ABSENT ? vec2(0.0) : vertex_vec2(base + offset);
}

vec4 vertex_color(uint base) {
    return kColorOffset == ATTRIBUTE_ABSENT ? vec4(1.0) : vertex_vec4(base + kColorOffset);
}

/// World, unit.
vec3 vertex_normal(InstanceData instance, uint base) {
    return normalize(to_world_normal(instance, vertex_vec3(base + kNormalOffset)));
}

/// World, and its handedness; 0 where the scene has none.
vec4 vertex_tangent(InstanceData instance, uint base) {
    if (kTangentOffset == ATTRIBUTE_ABSENT) return vec4(0.0);
    vec4 tangent = vertex_vec4(base + kTangentOffset);
    return vec4(to_world_tangent(instance, tangent.xyz), tangent.w * handedness(instance));
}

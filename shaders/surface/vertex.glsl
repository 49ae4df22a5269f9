// SPDX-License-Identifier: Apache-2.0
// Vertices and instances pulled from storage buffers: by vertex shaders, and by whoever evaluates a
// triangle anew (visibility.glsl).

#include "shared/scene.h"
#include "surface/gbuffer.h"

layout(constant_id = SPEC_VERTEX_STRIDE) const uint kVertexStride = 2;
layout(constant_id = SPEC_TANGENT_OFFSET) const uint kTangentOffset = ATTRIBUTE_ABSENT;
layout(constant_id = SPEC_UV1_OFFSET) const uint kUv1Offset = ATTRIBUTE_ABSENT;
layout(constant_id = SPEC_COLOR_OFFSET) const uint kColorOffset = ATTRIBUTE_ABSENT;

layout(scalar, binding = 20) readonly buffer Vertices { vec4 items[]; } vertices;
layout(scalar, binding = 21) readonly buffer Instances { InstanceData items[]; } instances;

/// What every vertex has, in two loads: (position, u), (normal, v).
struct Vertex {
    vec3 position;
    vec3 normal;
    vec2 uv0; // 0 where the scene has none
};

/// `base`: index of the vertex times kVertexStride.
Vertex fetch_vertex(uint base) {
    vec4 a = vertices.items[base], b = vertices.items[base + 1u];
    return Vertex(a.xyz, b.xyz, vec2(a.w, b.w));
}

vec2 fetch_uv1(uint base) {
    return kUv1Offset == ATTRIBUTE_ABSENT ? vec2(0.0) : vertices.items[base + kUv1Offset].xy;
}

vec4 fetch_color(uint base) {
    return kColorOffset == ATTRIBUTE_ABSENT ? vec4(1.0) : vertices.items[base + kColorOffset];
}

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

/// World, and its handedness; 0 where the scene has none.
vec4 fetch_tangent(InstanceData instance, uint base) {
    if (kTangentOffset == ATTRIBUTE_ABSENT) return vec4(0.0);
    vec4 tangent = vertices.items[base + kTangentOffset];
    return vec4(to_world_tangent(instance, tangent.xyz), tangent.w * handedness(instance));
}

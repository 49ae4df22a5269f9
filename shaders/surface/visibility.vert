// SPDX-License-Identifier: Apache-2.0
// reads triangles, instances, frame; writes clip position and the triangle's id. Without an index
// buffer, since gl_PrimitiveID is not everywhere in fragment shaders: gl_VertexIndex counts corners.
// MASKED adds what an alpha test needs.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "shared/frame.h"
#include "surface/vertex.glsl"

layout(scalar, binding = 0) uniform Frame { FrameData data; } frame;
layout(scalar, binding = 22) readonly buffer Indices { uint items[]; } indices;

layout(location = 0) flat out uint out_triangle;
#ifdef MASKED
layout(location = 1) out vec2 out_uv0;
layout(location = 2) out vec2 out_uv1;
layout(location = 3) out float out_alpha;
#endif

layout(push_constant, scalar) uniform Push { VisibilityPush push; };

/// Moves a corner to a grid of 1/256 sample, a quarter step off the rasteriser's own (of 1/256 or
/// 1/16), so that it rounds alike wherever the picture's origin stands in the target: screen tiles
/// cover the same samples as a whole picture.
vec4 snap(vec4 p) {
    if (p.w <= frame.data.near_distance) return p; // to be clipped
    vec2 steps = p.xy / p.w * push.steps;
    return vec4((floor(steps + 0.25) + 0.25) / push.steps * p.w, p.zw);
}

void main() {
    InstanceData instance = instances.items[gl_InstanceIndex];
    uint base = uint(int(indices.items[gl_VertexIndex]) + push.vertex_offset) * kVertexStride;
    Vertex vertex = fetch_vertex(base);
    gl_Position = snap(frame.data.view_projection * vec4(to_world(instance, vertex.position), 1.0));
    out_triangle = push.first_triangle +
                   (uint(gl_InstanceIndex) - push.first_instance) * push.triangles_per_instance +
                   (uint(gl_VertexIndex) - push.first_index) / 3u;
#ifdef MASKED
    out_uv0 = vertex.uv0;
    out_uv1 = fetch_uv1(base);
    out_alpha = fetch_color(base).a;
#endif
}

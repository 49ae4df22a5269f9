// SPDX-License-Identifier: Apache-2.0
// fetch_surface: one sample of the supersampled G-buffer, whatever its layout.
// Needs `frame` (shared/frame.h).

#include "surface/packing.glsl"

layout(binding = 1) uniform usampler2D gbuffer;
layout(binding = 2) uniform sampler2D gbuffer_depth;
#ifdef EXTRA
layout(binding = 3) uniform usampler2D gbuffer_extra;
#endif

struct SurfaceSample {
    vec3 normal;   // world, unit, towards the camera's side
    uint material;
    float depth;   // stored: reversed, 0 = background
    TextureCoordinates coordinates[2];
    vec3 color;    // vertex colour factor
};

SurfaceSample fetch_surface(ivec2 position) {
    uvec4 words = texelFetch(gbuffer, position, 0);
    SurfaceSample s;
    s.depth = texelFetch(gbuffer_depth, position, 0).x;
    s.normal = unpack_normal(words);
    s.material = unpack_material(words);
    s.coordinates[0] = unpack_coordinates(words.yzw);
#ifdef EXTRA
    uvec4 extra = texelFetch(gbuffer_extra, position, 0);
    s.color = unpack_color(extra.x);
    s.coordinates[1] = unpack_coordinates(extra.yzw);
#else
    s.color = vec3(1.0);
    s.coordinates[1] = s.coordinates[0];
#endif
    return s;
}

/// Place in the window of its index-th sample, row-major.
ivec2 window_offset(int index) {
    int m = int(frame.data.m);
    return ivec2(index % m, index / m);
}

/// Distance along the camera's forward axis, world units. Background: frame.background_depth.
float view_depth(float stored) {
    if (stored <= 0.0) return frame.data.background_depth;
    return frame.data.orthographic != 0u ? frame.data.far_distance * (1.0 - stored)
                                         : frame.data.near_distance / stored;
}

/// World position of the centre of a sample at a view depth.
vec3 sample_world(ivec2 position, float depth) {
    vec2 extent = vec2(frame.data.size * frame.data.m);
    vec2 ndc = (vec2(position) + 0.5) / extent * vec2(2.0, -2.0) + vec2(-1.0, 1.0);
    vec3 across = ndc.x * frame.data.right + ndc.y * frame.data.up;
    return frame.data.position + depth * frame.data.forward +
           (frame.data.orthographic != 0u ? across : across * depth);
}

/// Direction from a surface point to the camera, unit.
vec3 to_camera(vec3 world) {
    return frame.data.orthographic != 0u ? -frame.data.forward
                                         : normalize(frame.data.position - world);
}

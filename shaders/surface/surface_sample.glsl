// SPDX-License-Identifier: Apache-2.0
// fetch_surface: one sample of the supersampled G-buffer, whatever its layout: packed attributes,
// or (VISIBILITY) the id of a triangle, which is evaluated anew where it is asked for.
// Needs `frame` (shared/frame.h). Positions are samples of the images, not of the whole picture.

#include "surface/camera.glsl"
#include "surface/packing.glsl"

struct SurfaceSample {
    vec3 normal;   // world, unit, towards the camera's side
    uint material;
    float depth;   // stored: reversed, 0 = background
    TextureCoordinates coordinates[2];
    vec3 color;    // vertex colour factor
#ifdef VISIBILITY
    uint triangle;
#endif
};

/// Stored depth is linear over the picture on a plane, in either projection.
struct SurfacePlane {
    float depth; // stored: reversed, 0 = background, with no slope
    vec2 slope;  // change of the stored depth per sample to the right and down
    uint material;
};

/// Place in the window of its index-th sample, row-major.
ivec2 window_offset(int index) {
    int m = int(frame.data.m);
    return ivec2(index % m, index / m);
}

/// Straight on from coordinates `c` by `offset` samples, `other` is somewhere else.
bool coordinates_break(TextureCoordinates c, vec2 other, ivec2 offset) {
    vec2 step = vec2(offset.x) * c.gradient_x + vec2(offset.y) * c.gradient_y;
    vec2 difference = other - c.uv - step;
    difference -= round(difference);
    return length(difference) > 0.5 * length(step) + 4.0 / 1048576.0;
}

#ifdef VISIBILITY
#include "surface/visibility.glsl"
#else
const bool kShadingDataTextures = true; // where they are bound at all

layout(binding = 1, rgba32ui) uniform readonly uimage2D gbuffer;
layout(binding = 2) uniform sampler2D gbuffer_depth;
#ifdef EXTRA
layout(binding = 3, rgba32ui) uniform readonly uimage2D gbuffer_extra;
#endif
#ifdef SLOPES
layout(binding = 25, r32ui) uniform readonly uimage2D gbuffer_slopes;
#endif

/// Stored depth; 0: background, and whatever else the sample holds is undefined.
float fetch_depth(ivec2 position) { return texelFetch(gbuffer_depth, position, 0).x; }
uint fetch_material(ivec2 position) { return unpack_material(imageLoad(gbuffer, position)); }
/// The normal as pack_normal() has it: equal words are equal normals.
uint fetch_normal_word(ivec2 position) { return imageLoad(gbuffer, position).x; }
vec3 fetch_normal(ivec2 position) { return unpack_normal(fetch_normal_word(position)); }

SurfaceSample fetch_surface(ivec2 position) {
    uvec4 words = imageLoad(gbuffer, position);
    SurfaceSample s;
    s.depth = fetch_depth(position);
    s.normal = unpack_normal(words.x);
    s.material = unpack_material(words);
    s.coordinates[0] = unpack_coordinates(words.yzw);
#ifdef EXTRA
    uvec4 extra = imageLoad(gbuffer_extra, position);
    s.color = unpack_color(extra.x);
    s.coordinates[1] = unpack_coordinates(extra.yzw);
#else
    s.color = vec3(1.0);
    s.coordinates[1] = s.coordinates[0];
#endif
    return s;
}

#ifdef SLOPES
SurfacePlane fetch_plane(ivec2 position) {
    float depth = fetch_depth(position);
    vec2 relative = unpackHalf2x16(imageLoad(gbuffer_slopes, position).x);
    return SurfacePlane(depth, depth > 0.0 ? depth * relative : vec2(0.0), fetch_material(position));
}
#endif

/// True where the straight continuation of `s` by `offset` samples meets other material or
/// coordinates: a footprint must not reach across (Hollaender et al. 2013, section 4.1).
bool discontinuous(ivec2 position, SurfaceSample s, ivec2 offset) {
    ivec2 other_position = position + offset;
    if (fetch_depth(other_position) <= 0.0) return true;
    uvec4 other = imageLoad(gbuffer, other_position);
    if (unpack_material(other) != s.material) return true;
    return coordinates_break(s.coordinates[0], unpack_coordinates(other.yzw).uv, offset);
}
#endif

/// Geometric normal of a plane that is not background: world, unit, towards the camera.
vec3 plane_normal(ivec2 position, SurfacePlane plane) {
    // Points P of the plane have stored depth d: under perspective n / d = (P - camera) . forward.
    vec3 x = sample_right(), y = sample_down(), across = sample_across(position);
    vec3 right = x / dot(x, x), down = y / dot(y, y); // dual to x and y
    vec3 normal;
    if (frame.data.orthographic != 0u) {
        // Depth falls by far * slope per sample.
        normal = -frame.data.forward - frame.data.far_distance * (plane.slope.x * right + plane.slope.y * down);
    } else {
        // slope . (x, y) and depth at this sample fix the covector that gives depth for directions.
        vec2 at = vec2(dot(across, right), dot(across, down));
        normal = -(plane.slope.x * right + plane.slope.y * down +
                   (plane.depth - dot(plane.slope, at)) * frame.data.forward);
    }
    return normalize(normal);
}

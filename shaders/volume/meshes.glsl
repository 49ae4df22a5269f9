// SPDX-License-Identifier: Apache-2.0
// Meshes that stand in the medium. A picture with them has rays through the samples of the meshes'
// G-buffer, one after the other in their order, and is by how much the medium changes that of the
// meshes alone:
//   L - L_mesh = L_medium - (1 - T) L_mesh
//   reads mesh_ends, mesh_radiance (not CELLS): where camera rays meet meshes or opaque isosurfaces,
//   which are samples of the same G-buffer, and what they see there
//   reads sun_map: how far the sun reaches
// Here they end camera rays and stop the sun; what has been scattered meets them in volume/mesh_tree.glsl.
// Include after volume/medium.glsl and, with SURFACES, volume/surface.glsl.
#ifndef OCKHAM_VOLUME_MESHES_GLSL
#define OCKHAM_VOLUME_MESHES_GLSL

#include "include/sun_map.glsl"
#include "volume/meshes.h"

layout(constant_id = SPEC_SUN_MAP) const bool kSunMap = true; // else another image stands in for it
layout(constant_id = SPEC_ISO_SAMPLES) const bool kIsoSamples = false;
layout(constant_id = SPEC_TRANSLUCENT) const bool kTranslucent = true;

layout(binding = 16) uniform sampler2D sun_map;

#ifndef CELLS
layout(binding = 15) uniform usampler2D mesh_ends; // shaders/volume/mesh_ends.comp
layout(binding = 17) uniform sampler2DArray mesh_radiance;

/// Place in the pixel of its `index`-th ray.
vec2 mesh_ray_place(uint index) {
    uint m = constants.window, at = medium_frame.data.sample_order[index % (m * m)];
    return (vec2(at % m, at / m) + 0.5) / float(m);
}
uint mesh_end(ivec2 pixel, uint index) {
    uint m = constants.window, rank = index % (m * m);
    return texelFetch(mesh_ends, pixel * int(m) + ivec2(rank % m, rank / m), 0).x;
}
/// Where that ray ends, world units; kInfinity: it meets no mesh. Opaque isosurfaces end it as well,
/// but for a PATH, which scatters there: its ray ends a little behind them.
float mesh_ray_end(ivec2 pixel, uint index) {
    float end = uintBitsToFloat(mesh_end(pixel, index) & ~3u);
#if defined(SURFACES) && defined(PATH)
    if (kIsoSamples) end += beyond_hit() + 2e-6 * end; // distances are rounded to 2^-21
#endif
    return end;
}
#ifdef SURFACES
/// A camera ray's search has met what the ray ends at.
bool is_ray_end(SurfaceHit hit) {
    return kIsoSamples && hit.surface != kNoSurface && frame.data.surfaces[hit.surface].opacity >= 1.0;
}
#endif
/// Radiance that it sees there, as if there were no medium.
vec3 mesh_ray_radiance(ivec2 pixel, uint index) {
    return texelFetch(mesh_radiance, ivec3(pixel, mesh_end(pixel, index) & 3u), 0).xyz;
}
#endif

/// Share of the sun that meshes let through to a point.
float sun_reaches(vec3 world) {
    if (!kSunMap) return 1.0;
    return sun_map_share(sun_map, (constants.sun_projection * vec4(world, 1.0)).xyz);
}

/// Where to ask that of a point on a surface, which stands in its own way in the texels that it
/// shares with others.
vec3 sun_side(vec3 world, vec3 normal) {
    float cosine = dot(normal, constants.light_direction);
    mat4 p = constants.sun_projection; // the rows of x and y are 2 / (size of the map in the world) long
    float across = min(length(vec3(p[0].x, p[1].x, p[2].x)), length(vec3(p[0].y, p[1].y, p[2].y)));
    float texel = 2.0 / (across * float(textureSize(sun_map, 0).x));
    return world + texel * (0.5 + 2.0 * sqrt(max(1.0 - cosine * cosine, 0.0))) * normal;
}

#endif

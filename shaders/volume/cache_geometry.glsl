// SPDX-License-Identifier: Apache-2.0
// Where cells of the cache lie, the point that stands for each, and what that point sees.
// Include after volume/medium.glsl.
#ifndef OCKHAM_VOLUME_CACHE_GEOMETRY_GLSL
#define OCKHAM_VOLUME_CACHE_GEOMETRY_GLSL

#include "volume/cache.h"

float cache_luminance(vec3 radiance) { return dot(radiance, vec3(0.2126, 0.7152, 0.0722)); }

uvec3 cache_grid(uint scale) { return (frame.data.dims + scale - 1u) / scale; }
uvec3 cache_cell(uint index, uvec3 grid) {
    return uvec3(index % grid.x, index / grid.x % grid.y, index / (grid.x * grid.y));
}

/// The part of a cell, in unit coordinates, that lies in the box and the crop box.
void cache_bounds(uvec3 cell, uint scale, out vec3 low, out vec3 high) {
    vec3 dims = vec3(frame.data.dims);
    low = clamp(vec3(cell * scale) / dims, frame.data.crop_min, frame.data.crop_max);
    high = clamp(vec3((cell + 1u) * scale) / dims, frame.data.crop_min, frame.data.crop_max);
}

/// One of 4 x 4 x 4 places in the cell, which at scale 4 are its voxels.
vec3 cache_place(uint place, vec3 low, vec3 high) {
    vec3 fraction = vec3(place & 3u, place >> 2u & 3u, place >> 4u) * 0.25 + 0.125;
    return mix(low, high, fraction);
}
/// The point whose light the cell's value is: the centre, unless a surface or a clip plane is near.
vec3 cache_representative(uvec3 cell, uint scale, uint word) {
    vec3 low, high;
    cache_bounds(cell, scale, low, high);
    bool near = (word & CACHE_NEAR) != 0u;
    return near ? cache_place(word >> CACHE_PLACE_SHIFT & 63u, low, high) : 0.5 * (low + high);
}

/// A bit per isovalue: whether a point lies inside that surface.
uint cache_sides(vec3 unit) {
    float value = field(unit);
    uint sides = 0u;
    for (uint k = 0u; k < frame.data.surface_count; ++k)
        sides |= uint(value >= frame.data.surfaces[k].value) << k;
    return sides;
}
/// Isovalues whose inside is dark.
uint cache_opaque_surfaces() {
    uint opaque = 0u;
    for (uint k = 0u; k < frame.data.surface_count; ++k)
        opaque |= uint(frame.data.surfaces[k].opacity >= 1.0) << k;
    return opaque;
}
/// Whether a point is behind no clip plane.
bool cache_kept(vec3 unit) {
    vec4 world = vec4(world_from_unit(unit), 1.0);
    for (uint i = 0u; i < frame.data.clip_count; ++i)
        if (dot(frame.data.clip_planes[i], world) < 0.0) return false;
    return true;
}

const uint kHidden = 0u;   // an opaque surface stands between
const uint kGlimpsed = 1u; // translucent ones do
const uint kSeen = 2u;

/// How a point sees the representative of a cell near a surface. Tests the field every half voxel,
/// and neither end: the point may stand on the surface. Walls thinner than half a voxel may be
/// missed. `budget` loses the loop's iterations, and stops at 0.
uint cache_sees(vec3 from, vec3 representative, inout uint budget) {
    uint sides = cache_sides(representative), opaque = cache_opaque_surfaces(), crossed = 0u;
    vec3 way = representative - from;
    vec3 voxels = abs(way) * vec3(frame.data.dims);
    uint steps = uint(2.0 * max(max(voxels.x, voxels.y), voxels.z)) + 1u;
    for (uint i = 0u; i < steps && (crossed & opaque) == 0u; ++i)
        crossed |= cache_sides(from + way * ((float(i) + 0.5) / float(steps))) ^ sides;
    budget -= min(budget, (steps + 2u) * (frame.data.surface_count + 1u));
    return (crossed & opaque) != 0u ? kHidden : crossed != 0u ? kGlimpsed : kSeen;
}

#endif

// SPDX-License-Identifier: Apache-2.0
// Local shading of a hit on an isosurface: one directional light, seen through medium and surfaces,
// and an environment that is not occluded.
//   L = f(v, l) cos E T  +  diffuse albedo * mean environment
// Before surface_gain. T, the visibility, is found step by step under a loop budget; paths that have
// a shadow ray of their own take the two other terms alone. Include after volume/surface.glsl,
// include/iso_bsdf.glsl and include/random.glsl.
#ifndef OCKHAM_VOLUME_SHADE_SURFACE_GLSL
#define OCKHAM_VOLUME_SHADE_SURFACE_GLSL

/// Surfaces are shaded on the side that is seen.
vec3 facing_normal(SurfaceHit hit, vec3 view) {
    return dot(hit.normal, view) < 0.0 ? -hit.normal : hit.normal;
}

/// Radiance towards `view` (unit, away from the surface) from the directional light, as if nothing
/// stood between.
vec3 reflected_light(SurfaceHit hit, vec3 view) {
    return evaluate_iso(frame.data.surfaces[hit.surface].material, frame.data.shading,
               facing_normal(hit, view), view, -frame.data.light_direction) *
           frame.data.light_irradiance;
}

/// Radiance from an environment that is as bright everywhere as its mean.
vec3 reflected_environment(SurfaceHit hit) {
    IsoMaterial material = frame.data.surfaces[hit.surface].material;
    float diffuse = frame.data.shading == SHADING_DISNEY ? 1.0 - material.metallic : 1.0;
    return diffuse * material.base_color * frame.data.environment;
}

/// How much of the directional light arrives at a point, so far. Begin with begin_visibility().
struct Visibility {
    float value;
    float t;      // from the point on, towards the light: all before is counted
    uint cell;    // where `t` is, packed
    bool medium;  // the surfaces are counted, the medium is under way
};

const float kShadowOffset = 0.01; // voxels: beyond rounding of the hit, within its cell

/// Longest step, in world units, that stays within a voxel along each axis.
float voxel_length() {
    vec3 edges = vec3(length(frame.data.world_from_unit[0]), length(frame.data.world_from_unit[1]),
                     length(frame.data.world_from_unit[2])) / vec3(frame.data.dims);
    return min(min(edges.x, edges.y), edges.z);
}

Visibility begin_visibility() { return Visibility(1.0, kShadowOffset * voxel_length(), 0u, false); }

uint pack_cell(ivec3 cell) {
    uvec3 c = uvec3(clamp(cell, ivec3(0), ivec3(1023)));
    return c.x | c.y << 10 | c.z << 20;
}
ivec3 unpack_cell(uint cell) { return ivec3(cell & 1023u, cell >> 10 & 1023u, cell >> 20); }

/// Goes on towards the light from `origin` (world, inside the box): surfaces first, each lets
/// 1 - opacity through, then the medium by ratio tracking with local majorants, ended by Russian
/// roulette where little is left. True: it is done. False: the budget is used up, call again with
/// the same origin. Whatever the budgets, the value is the same, provided that find_surface() can
/// finish within one.
bool advance_visibility(
    inout Visibility seen, vec3 origin, inout Random random, inout uint budget) {
    vec3 direction = -frame.data.light_direction;
    float near, far;
    vec3 entry_normal;
    bool inside = clip_ray(origin, direction, near, far, entry_normal);
    if (!inside || seen.t >= far) return true;

    vec3 o = unit_from_world(origin), d = unit_from_world_direction(direction);
    if (!seen.medium) {
        SurfaceHit hit;
        bool met = true;
        while (met && seen.value > 0.0 && budget > 0u) {
            --budget;
            met = find_surface(origin, direction, seen.t, far, false, entry_normal, budget, hit);
            if (met) {
                seen.value *= 1.0 - frame.data.surfaces[hit.surface].opacity;
                seen.t = hit.t + kShadowOffset * voxel_length();
            }
        }
        if (seen.value == 0.0) return true;
        if (met || budget == 0u) return false;
        seen.medium = true;
        seen.t = near;
        seen.cell = pack_cell(walk_cells(o, d, near).cell);
    }

    CellWalk walk = walk_cells(o, d, seen.t);
    walk.cell = unpack_cell(seen.cell);
    walk.exits = vec3(wall_crossing(walk, 0), wall_crossing(walk, 1), wall_crossing(walk, 2));
    bool done = false;
    while (!done && budget > 0u) {
        --budget;
        float exit = min(majorant_exit(walk), far);
        float majorant = cell_majorant(cell_index(walk));
        vec4 xi = next4(random);
        float step = majorant > 0.0 ? -log(xi.x) / majorant : kInfinity;
        if (seen.t + step < exit) {
            seen.t += step;
            seen.value *= max(1.0 - medium_of(field(o + seen.t * d)).sigma_t / majorant, 0.0);
            if (seen.value < 0.1) seen.value = xi.y < 10.0 * seen.value ? 0.1 : 0.0;
            done = seen.value == 0.0;
        } else {
            seen.t = exit;
            done = exit >= far;
            next_cell(walk);
        }
    }
    if (!done) seen.cell = pack_cell(walk.cell);
    return done;
}

#endif

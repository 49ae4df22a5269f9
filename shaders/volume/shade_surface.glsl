// SPDX-License-Identifier: Apache-2.0
// Local shading of a hit on an isosurface: one directional light, seen through medium and surfaces,
// and an environment that is not occluded.
//   L = f(v, l) cos E T  +  diffuse albedo * mean environment
// before surface_gain. T, the visibility, is found under a loop budget; paths that have a shadow ray
// of their own take the other terms alone. Include after volume/cells.glsl, volume/surface.glsl,
// include/iso_bsdf.glsl and include/random.glsl.
#ifndef OCKHAM_VOLUME_SHADE_SURFACE_GLSL
#define OCKHAM_VOLUME_SHADE_SURFACE_GLSL

#include "volume/tracking.glsl"

/// Surfaces are shaded on the side that is seen.
vec3 facing_normal(SurfaceHit hit, vec3 view) {
    return dot(hit.normal, view) < 0.0 ? -hit.normal : hit.normal;
}

/// Radiance towards `view` (unit, away from the surface) from the directional light, as if nothing
/// stood between.
vec3 reflected_light(SurfaceHit hit, vec3 view) {
    return evaluate_iso(frame.data.surfaces[hit.surface].material, constants.shading,
               facing_normal(hit, view), view, -constants.light_direction) *
           constants.light_irradiance;
}

/// Radiance from an environment that is as bright everywhere as its mean.
vec3 reflected_environment(SurfaceHit hit) {
    IsoMaterial material = frame.data.surfaces[hit.surface].material;
    return iso_diffuse_albedo(material, constants.shading) * constants.environment;
}

/// How much of the directional light arrives at a point, so far.
struct Visibility {
    float value;
    float t;     // towards the light: all before is counted
    uint cell;   // where t is, packed
    bool medium; // the surfaces are counted, the medium is under way
};

Visibility begin_visibility() { return Visibility(1.0, 0.0, 0u, false); }

/// Where to begin: beside the hit, on the light's side.
vec3 shadow_origin(SurfaceHit hit, vec3 position) {
    return off_surface(position, hit.normal, -constants.light_direction);
}

/// Goes on towards the light from `origin`, where shadow_origin() says: surfaces first, each lets
/// 1 - opacity through, then the medium, by ratio tracking with local majorants and Russian roulette
/// where little is left. True: it is done. False: the budget is used up, call again with the same
/// origin and random numbers. The value does not depend on the budgets.
bool advance_visibility(inout Visibility seen, vec3 origin, inout Random random, inout uint budget) {
    vec3 direction = -constants.light_direction;
    float near, far;
    vec3 entry_normal;
    if (!clip_ray(origin, direction, near, far, entry_normal)) return true;

    bool searching = !seen.medium;
    if (searching) seen.t = max(seen.t, near);
    while (searching && budget > 0u) {
        SurfaceHit hit;
        bool met = find_surface(origin, direction, seen.t, far, false, entry_normal, budget, hit);
        seen.t = hit.t;
        if (met) {
            seen.value *= 1.0 - frame.data.surfaces[hit.surface].opacity;
            seen.t += beyond_hit();
        }
        searching = seen.t < far && seen.value > 0.0;
    }
    if (seen.value == 0.0) return true;
    if (searching) return false;

    Flight flight;
    flight.origin = unit_from_world(origin);
    flight.direction = unit_from_world_direction(direction);
    flight.limit = far;
    flight.majorant = constants.majorant;
#ifdef GRID
    flight.walk = walk_cells(flight.origin, flight.direction, near);
    if (seen.medium) flight.walk.cell = unpack_cell(seen.cell);
#endif
    if (!seen.medium) seen.t = near;
    seen.medium = true;
    while (seen.value > 0.0 && seen.t < far && budget > 0u) {
        budget -= min(budget, 1u + kFlightCells);
        vec4 xi = independent4(random);
        ++random.set;
        float depth = depth_of(xi.x), value;
        if (fly(flight, seen.t, depth))
            seen.value = ratio_tracked(seen.value, collision_chance(flight, seen.t, value), xi.y);
    }
#ifdef GRID
    seen.cell = pack_cell(flight.walk);
#endif
    return seen.value == 0.0 || seen.t >= far;
}

#endif

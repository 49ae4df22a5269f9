// SPDX-License-Identifier: Apache-2.0
// Light that is scattered in the medium and by its surfaces, followed backwards (Novak et al. 2018,
// "Monte Carlo methods for volumetric light transport simulation"): delta tracking with a majorant
// per cell, next-event estimation by ratio tracking, multiple importance sampling of an environment
// map, Russian roulette. One of these says what a path is:
//   PATH        pixels; surfaces scatter
//   NONCACHING  pixels; the camera's ray ends on a surface, which is shaded locally; behind a
//               scattering, surfaces are black
//   GATHER      as NONCACHING, but in-scattering at the second collision is read from the cache
//   CELLS       mean radiance that arrives at a point; surfaces are black
// advance() is one iteration of one flat loop over the stages of all samples:
//   Path path = begin_camera_path(...);  Tracker tracker = resume(path);
//   while (path.stage != PATH_ENDED && budget > 0u) advance(path, tracker, budget);
//   suspend(path, tracker);   // to be stored; the next dispatch goes on with resume(path)
// Where a budget ends changes nothing: results are equal bit for bit.
#ifndef OCKHAM_VOLUME_PATH_GLSL
#define OCKHAM_VOLUME_PATH_GLSL

#include "include/phase.glsl"
#include "include/random.glsl"
#include "volume/cells.glsl"
#include "volume/environment.glsl"
#include "volume/path.h"
#ifdef SURFACES
#include "include/iso_bsdf.glsl"
#include "volume/surface.glsl"
#include "volume/shade_surface.glsl"
#endif
#ifdef GATHER
#include "volume/cache_lookup.glsl"
#endif

#ifndef PATH_NEE // whether the environment map is sampled at collisions; a directional light always is
#define PATH_NEE true
#endif

const float kRouletteTransmittance = 0.1; // shadow rays below it live on by chance

#ifdef GATHER
// Of a lookup in the cache: eight cells, each with a loop over the surfaces for the side of its
// representative, and one for every step to it. No cell that is blended has its centre further away
// than one cell along an axis, nor its representative further from that than half a cell: 6 voxels
// at scale 4, two steps a voxel and one more. With four surfaces 8 (1 + 4 + 13 * 5) = 560.
#ifdef SURFACES
const uint kLookupIterations = 8u * (1u + MAX_SURFACES + 13u * (MAX_SURFACES + 1u));
#else
const uint kLookupIterations = 9u;
#endif
#endif

// Iterations of loops within one call of advance(): steps along a ray, of the search for surfaces (a
// slice, and a bisection of 20), of a lookup in the cache, of clip planes. Lanes that run together
// take them together, so that the sum bounds those of all.
const uint kStride = 20u;
const uint kSearchSlice = 16u;
const uint kAdvanceIterations = 1u + kStride + MAX_CLIP_PLANES
#ifdef SURFACES
    + kSearchSlice + 20u
#endif
#ifdef GATHER
    + kLookupIterations
#endif
    ;

uint path_steps = 0u;   // tentative collisions, a lookup of the field each
uint path_clamped = 0u; // those with an extinction above its majorant: never

/// What follows from a path and the frame: how its present ray goes through the box.
struct Tracker {
    bool ready; // the rest is of the present ray
    CellWalk walk;
    float limit; // where the ray leaves the medium or meets a surface
#ifdef SURFACES
    SurfaceHit hit;
#endif
};

vec4 draw(inout Path path) {
    Random random = Random(path.random.x, path.random.y, path.random.z, path.random.w);
    vec4 xi = next4(random);
    path.random.w = random.set;
    return xi;
}
/// Exponentially distributed; no less than 0 whatever a driver's logarithm says near 1.
float depth_of(float xi) { return max(-log(xi), 0.0); }
/// As of medium_of(), which reads more.
float extinction_of(float value) {
    uint entry;
    float fraction;
    table_place(value, entry, fraction);
    return frame.data.density_scale *
        mix(transfer.entries[entry].w, transfer.entries[entry + 1u].w, fraction);
}
float greatest_of(vec3 v) { return max(max(v.x, v.y), v.z); }

Tracker resume(Path path) {
    Tracker tracker;
    tracker.ready = false;
    return tracker;
}
void suspend(inout Path path, Tracker tracker) {
    if (tracker.ready) path.cell = pack_cell(tracker.walk);
}

Path begin_path(vec3 origin, vec3 direction, Random random) {
    Path path;
    path.radiance = vec3(0.0);
    path.throughput = vec3(1.0);
    path.origin = origin;
    path.direction = direction;
    path.pending = vec3(0.0);
    path.to_light = -frame.data.light_direction;
    path.transmittance = 1.0;
    path.t = -1.0;
    path.pdf = -1.0;
    path.search = -1.0;
    path.cell = 0u;
    path.stage = PATH_FLIGHT;
    path.bounces = 0u;
    path.random = uvec4(random.seed, random.stream, random.index, random.set);
    path.depth = depth_of(draw(path).x);
    return path;
}

/// `direction` unit, world.
Path begin_camera_path(vec3 origin, vec3 direction, Random random) {
    return begin_path(origin, direction, random);
}

/// Light chosen at a collision: one of the directional light and the environment map.
struct LightSample {
    vec3 direction; // towards it
    vec3 radiance;  // over the chance to choose it, and over its density where it has one
    float pdf;      // density, with that chance; 0: a light from one direction only
};

/// Chance that the directional light is chosen.
float directional_share() {
#ifdef ENVIRONMENT_MAP
    if (!PATH_NEE) return 1.0;
    return greatest_of(frame.data.light_irradiance) > 0.0 ? 0.5 : 0.0;
#else
    return 1.0;
#endif
}

LightSample sample_light(inout Path path) {
#ifdef ENVIRONMENT_MAP
    vec4 xi = draw(path);
    float share = directional_share();
    if (xi.x >= share) {
        LightSample light;
        light.radiance = sample_environment(xi.yz, light.direction, light.pdf);
        light.pdf *= 1.0 - share;
        light.radiance = light.pdf > 0.0 ? light.radiance / light.pdf : vec3(0.0);
        return light;
    }
    return LightSample(-frame.data.light_direction, frame.data.light_irradiance / share, 0.0);
#else
    return LightSample(-frame.data.light_direction, frame.data.light_irradiance, 0.0);
#endif
}

/// Radiance from where a flight leaves for good. Balance heuristic against sample_light().
vec3 escaped_radiance(Path path) {
    vec3 radiance = environment_radiance(path.direction);
#ifdef ENVIRONMENT_MAP
    if (PATH_NEE && path.pdf >= 0.0) {
        float competing = (1.0 - directional_share()) * environment_pdf(path.direction);
        radiance *= path.pdf / (path.pdf + competing);
    }
#endif
    return radiance;
}

/// Sends a shadow ray from `position` for `scattered` = throughput times what of the light goes on
/// along the path per irradiance; `pdf`: density of the same direction if the flight had chosen it.
/// The flight follows it, if anything is left of it.
void leave(inout Path path, vec3 position, LightSample light, vec3 scattered, float pdf) {
    float weight = light.pdf > 0.0 ? light.pdf / (light.pdf + pdf) : 1.0;
    path.pending = scattered * light.radiance * weight;
    path.to_light = light.direction;
    path.transmittance = 1.0;
    path.origin = position;
    path.t = -1.0;
    path.search = 0.0;
    path.stage = greatest_of(path.pending) > 0.0 ? PATH_SHADOW
        : greatest_of(path.throughput) > 0.0     ? PATH_FLIGHT
                                                 : PATH_ENDED;
}

/// Russian roulette: `xi` uniform in (0, 1).
void play_roulette(inout Path path, float xi) {
    float survival = min(greatest_of(path.throughput), 1.0);
    path.throughput = xi < survival ? path.throughput / survival : vec3(0.0);
}

/// A real collision at `position`. xi: uniform for the roulette, then two for the direction.
void meet_medium(inout Path path, vec3 position, Medium medium, vec3 xi) {
#ifndef CELLS
    if (path.bounces == 0u) path.throughput *= frame.data.volume_gain;
#endif
#ifdef EMISSION
    path.radiance += path.throughput * (1.0 - medium.albedo) * medium.emitted;
#endif
    path.throughput *= medium.albedo;
    ++path.bounces;
    if (path.bounces > frame.data.max_bounces) path.throughput = vec3(0.0);
#ifdef GATHER
    if (path.bounces > 1u) {
        uint charged = kLookupIterations; // by advance()
        vec3 arriving = cached_in_scatter(unit_from_world(position), path.direction, charged);
        path.radiance += path.throughput * arriving;
        path.stage = PATH_ENDED;
        return;
    }
#endif
    float g = frame.data.phase_g;
    LightSample light = sample_light(path);
    float towards = phase(g, dot(path.direction, light.direction));
    vec3 scattered = path.throughput * towards;
    play_roulette(path, xi.x);
    vec3 next = sample_phase(g, path.direction, xi.yz);
    path.pdf = phase(g, dot(path.direction, next));
    path.direction = next;
    leave(path, position, light, scattered, towards);
}

#ifdef SURFACES
/// A flight meets the surface of `hit`.
void meet_surface(inout Path path, SurfaceHit hit, vec4 xi) {
    vec3 view = -path.direction;
    vec3 normal = facing_normal(hit, view);
    vec3 position = off_surface(path.origin + path.t * path.direction, normal, normal);
#ifdef PATH
    if (path.bounces == 0u) path.throughput *= frame.data.surface_gain;
    ++path.bounces;
    if (path.bounces > frame.data.max_bounces) path.throughput = vec3(0.0);
    IsoMaterial material = frame.data.surfaces[hit.surface].material;
    LightSample light = sample_light(path);
    vec3 scattered =
        path.throughput * evaluate_iso(material, frame.data.shading, normal, view, light.direction);
    float pdf = light.pdf > 0.0 ? pdf_iso(material, frame.data.shading, normal, view, light.direction) : 0.0;
    vec3 next;
    path.throughput *= sample_iso(material, frame.data.shading, normal, view, draw(path), next, path.pdf);
    play_roulette(path, xi.y);
    path.direction = next;
    leave(path, position, light, scattered, pdf);
#else
    path.stage = PATH_ENDED;
#ifndef CELLS
    if (path.bounces == 0u) { // local shading: its shadow ray is the path's last
        path.throughput *= frame.data.surface_gain;
        path.radiance += path.throughput * reflected_environment(hit);
        vec3 scattered = path.throughput * reflected_light(hit, view);
        path.throughput = vec3(0.0);
        ++path.bounces;
        leave(path, position, LightSample(-frame.data.light_direction, vec3(1.0), 0.0), scattered, 0.0);
    }
#endif
#endif
}
#endif

#ifdef CELLS
/// Mean incident radiance at a point of the box: as after a collision that scatters evenly and
/// absorbs nothing. Counts as a scattering. Inside an opaque solid it has ended, with 0.
Path begin_cell_path(vec3 position, Random random) {
    Path path = begin_path(position, vec3(0.0, 0.0, 1.0), random);
    path.bounces = 1u;
    vec4 xi = draw(path);
    path.direction = sample_phase(0.0, path.direction, xi.xy);
    path.pdf = 0.0795774715;
    LightSample light = sample_light(path);
    leave(path, position, light, vec3(path.pdf), path.pdf);
    bool inside = frame.data.max_bounces > 0u;
#ifdef SURFACES
    float value = exact_field(unit_from_world(position));
    for (uint i = 0u; i < MAX_SURFACES; ++i) {
        if (i < frame.data.surface_count && frame.data.surfaces[i].opacity == 1.0)
            inside = inside && value < frame.data.surfaces[i].value;
    }
#endif
    if (!inside) path.stage = PATH_ENDED;
    return path;
}
#endif

/// How the present ray goes through the box; false: surfaces are still being searched for.
bool set_out(inout Path path, inout Tracker tracker, vec3 direction) {
    float near, far;
    vec3 entry_normal;
    if (!clip_ray(path.origin, direction, near, far, entry_normal)) near = far = 0.0;
    vec3 o = unit_from_world(path.origin), d = unit_from_world_direction(direction);
    if (path.t < 0.0) {
        path.t = near;
        path.cell = pack_cell(walk_cells(o, d, near));
    }
    tracker.walk = resume_walk(o, d, path.cell);
    tracker.limit = far;
    tracker.ready = true;
#ifdef SURFACES
    tracker.hit.surface = kNoSurface;
    float from = path.search < 0.0 ? near : path.search;
    if (from < far) {
        uint slice = kSearchSlice;
        bool found = find_surface(path.origin, direction, from, far, path.search < 0.0, entry_normal,
            slice, tracker.hit);
        if (!found && tracker.hit.t < far) { // the slice is used up
            path.search = tracker.hit.t;
            tracker.ready = false;
        }
        tracker.limit = tracker.hit.t;
    }
#endif
    return tracker.ready;
}

/// Goes on with a path that has not ended: where its ray leads, if that is not known, then some steps
/// along it, then what happens there. All lanes do one after the other together.
void advance(inout Path path, inout Tracker tracker, inout uint budget) {
    budget -= min(budget, kAdvanceIterations);
    bool shadow = path.stage == PATH_SHADOW;
    vec3 direction = shadow ? path.to_light : path.direction;
    if (!tracker.ready && !set_out(path, tracker, direction)) return;

    vec4 xi = vec4(0.0);
    float value = 0.0, chance = 0.0; // of the field, and that the collision is real
    bool collided = false, arrived = false; // for real; at a surface or where the medium ends
    for (uint i = 0u; i < kStride && !collided && !arrived; ++i) {
        float majorant = cell_majorant(cell_index(tracker.walk));
        float leaves = min(majorant_exit(tracker.walk), tracker.limit);
        float most = majorant * max(leaves - path.t, 0.0);
        if (path.depth < most) {
            path.t += path.depth / majorant;
            xi = draw(path);
            path.depth = depth_of(xi.x);
            value = field((tracker.walk.origin + path.t * tracker.walk.direction) *
                (float(RANGE_CELL) / vec3(frame.data.dims)));
            chance = extinction_of(value) / majorant;
            ++path_steps;
            if (chance > 1.0 + 1e-4) ++path_clamped;
            chance = min(chance, 1.0);
            if (shadow) {
                path.transmittance *= 1.0 - chance;
                if (path.transmittance < kRouletteTransmittance) {
                    bool lives = xi.y * kRouletteTransmittance < path.transmittance;
                    path.transmittance = lives ? kRouletteTransmittance : 0.0;
                }
                collided = path.transmittance == 0.0;
            } else {
                collided = xi.y < chance;
            }
        } else {
            path.depth -= most;
            path.t = max(path.t, leaves);
            arrived = leaves >= tracker.limit;
            if (!arrived) next_cell(tracker.walk);
        }
    }
    if (!collided && !arrived) return;
    tracker.ready = false;

#ifdef SURFACES
    if (arrived && tracker.hit.surface != kNoSurface) {
        float opacity = frame.data.surfaces[tracker.hit.surface].opacity;
        xi = draw(path);
        if (shadow) path.transmittance *= 1.0 - opacity;
        collided = shadow ? path.transmittance == 0.0 : xi.x < opacity;
        if (!shadow && collided) {
            meet_surface(path, tracker.hit, xi);
            return;
        }
        if (!collided) { // goes on behind it
            path.search = tracker.hit.t + beyond_hit();
            path.cell = pack_cell(tracker.walk);
            return;
        }
    }
#endif
    if (shadow) {
        path.radiance += path.pending * path.transmittance;
        path.stage = greatest_of(path.throughput) > 0.0 ? PATH_FLIGHT : PATH_ENDED;
        path.t = -1.0;
        path.search = 0.0;
    } else if (collided) {
        vec3 position = path.origin + path.t * path.direction;
        meet_medium(path, position, medium_of(value), vec3(xi.y / chance, xi.zw));
    } else {
        path.radiance += path.throughput * escaped_radiance(path);
        path.stage = PATH_ENDED;
    }
}

#endif

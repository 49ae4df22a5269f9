// SPDX-License-Identifier: Apache-2.0
// Light that is scattered in the medium and by its surfaces, followed backwards (Novak et al. 2018,
// "Monte Carlo methods for volumetric light transport simulation"): delta tracking, next-event
// estimation by ratio tracking, multiple importance sampling of an environment map, Russian roulette.
// One of these says what a path is:
//   PATH        pixels; surfaces scatter
//   NONCACHING  pixels; the camera's ray ends on a surface, which is shaded locally; behind a
//               scattering, surfaces are black
//   GATHER      as NONCACHING, but in-scattering at the second collision is read from the cache
//   CELLS       mean radiance that arrives at a point; surfaces are black
// With MESHES, camera rays end on meshes, background and (not PATH) opaque isosurfaces, with 0: these
// have a picture of their own. All other flights meet the triangles of volume/mesh_tree.glsl
// (SPEC_MESH_TREE), which scatter evenly.
// advance() is one iteration of one flat loop over the stages of all samples:
//   Path path = begin_camera_path(...);  Tracker tracker = resume(path);
//   while (path.stage != PATH_ENDED && budget > 0u) advance(path, tracker, budget);
//   suspend(path, tracker);   // to be stored; the next dispatch goes on with resume(path)
// Where a budget ends changes nothing: results are equal bit for bit.
#ifndef OCKHAM_VOLUME_PATH_GLSL
#define OCKHAM_VOLUME_PATH_GLSL

#include "include/phase.glsl"
#include "include/random.glsl"
#include "volume/light.glsl"
#include "volume/path.h"
#include "volume/tracking.glsl"
#ifdef SURFACES
#include "include/iso_bsdf.glsl"
#include "volume/surface.glsl"
#include "volume/shade_surface.glsl"
#endif
#ifdef GATHER
#include "volume/cache_lookup.glsl"
#endif
#ifdef MESHES
#include "volume/lamps.glsl"
#include "volume/mesh_tree.glsl"
#include "volume/meshes.glsl"

layout(constant_id = SPEC_MESH_TREE) const bool kMeshTree = true; // else other buffers stand in for it
const uint kLongPath = 1024u; // scatterings from which on meshes end paths by chance
#ifndef CELLS
uint hidden_ends = 0u; // camera rays of this invocation that were stopped before they met a sample
#endif
#endif

const float kRouletteThroughput = 0.25; // paths below it live on by chance

#ifdef GATHER
// Of a lookup in the cache: eight cells, each with a loop over the surfaces for the side of its
// representative, and one for every step to it. No cell that is blended has its centre further away
// than one cell along an axis, nor its representative further from that than half a cell: 6 voxels
// at scale 4, two steps a voxel and one more. With four surfaces 8 (2 + 8 + 13 * 5) = 600.
#ifdef SURFACES
const uint kLookupIterations = 8u * (2u + 2u * MAX_SURFACES + 13u * (MAX_SURFACES + 1u));
#else
const uint kLookupIterations = 9u;
#endif
#endif

// Iterations of loops within one call of advance(): tentative collisions and the cells before each, the
// search for surfaces (a slice, and a bisection of 20), a lookup in the cache, clip planes. Lanes that
// run together take them together, so that the sum bounds those of all.
const uint kStride = 4u;
const uint kSearchSlice = 16u;
const uint kAdvanceIterations = 1u + kStride * (1u + kFlightCells) + MAX_CLIP_PLANES
#ifdef SURFACES
    + kSearchSlice + 20u
#endif
#ifdef GATHER
    + kLookupIterations
#endif
#ifdef MESHES
    + (kMeshTree ? kMeshIterations : 0u)
#endif
    ;

/// What follows from a path and the frame: how its present ray goes through the box.
struct Tracker {
    bool ready; // the rest is of the present ray
    Flight flight;
#ifdef SURFACES
    SurfaceHit hit; // at the flight's limit
#endif
};

// Sets of random numbers: two for each scattering, stratified over samples, and any number of others.
// Those before kPathSets belong to whoever begins paths.
const uint kPathSets = 16u;
const uint kStepSets = 1u << 31u;
#define SET_DIRECTION 0u // xy: where the flight goes, or the place in the pixel; z: depth, w: chance
#define SET_LIGHT 1u     // sample_light()

vec4 draw(Path path, uint set) {
    uint first = path.bounces > 0u ? kPathSets : 0u;
    Random random = Random(path.random.x, path.random.y, path.random.z, first + 2u * path.bounces + set);
    return next4(random);
}
/// Light that a path samples at `position`; of the sun, what meshes let through. `normal`: of the mesh
/// that the position lies beside, or 0.
LightSample light_at(Path path, vec3 position, vec3 normal) {
#ifdef ENVIRONMENT_MAP
    return sample_light(draw(path, SET_LIGHT));
#else
    LightSample light = sample_light(vec4(0.0));
#ifdef MESHES
    light.radiance *= sun_reaches(sun_side(position, normal));
    if (kLamps > 0u) { // one of both kinds
        vec2 xi = draw(path, SET_LIGHT).xy;
        float share = greatest_of(constants.light_irradiance) > 0.0 ? 0.5 : 0.0;
        light.radiance /= max(share, 0.5);
        if (xi.x >= share) light = sample_lamp(position, xi.y, 1.0 - share);
    }
#endif
    return light;
#endif
}
vec4 draw_step(inout Path path) {
    return independent4(Random(path.random.x, path.random.y, path.random.z, path.random.w++));
}

Tracker resume(Path path) {
    Tracker tracker;
    tracker.ready = false;
    return tracker;
}
void suspend(inout Path path, Tracker tracker) {
#ifdef GRID
    if (tracker.ready) path.cell = pack_cell(tracker.flight.walk);
#endif
}

Path begin_path(vec3 origin, uint stage, Random random) {
    Path path;
    path.radiance = vec3(0.0);
    path.throughput = vec3(1.0);
    path.origin = origin;
    path.direction = vec3(0.0, 0.0, 1.0);
    path.pending = vec3(0.0);
    path.to_light = -constants.light_direction;
    path.transmittance = 1.0;
    path.t = -1.0;
    path.depth = 0.0;
    path.chance = 0.0;
    path.pdf = -1.0;
    path.search = -1.0;
    path.cell = 0u;
    path.stage = stage;
    path.bounces = 0u;
    path.random = uvec4(random.seed, random.stream, random.index, kStepSets);
    return path;
}

/// `pixel`: upper left corner; `jitter`: somewhere in the pixel, else through its centre.
Path begin_camera_path(uvec2 pixel, bool jitter, Random random) {
    return begin_path(vec3(pixel, jitter ? 1.0 : 0.0), PATH_CAMERA, random);
}

/// Sends a path on its way: from the camera, or on from a collision in the medium.
void depart(inout Path path) {
    vec4 xi = draw(path, SET_DIRECTION);
    float g = constants.phase_g;
#ifdef CELLS
    if (path.bounces == 1u) g = 0.0;
#else
    if (path.stage == PATH_CAMERA) {
        vec2 place = mix(vec2(0.5), xi.xy, path.origin.z);
#ifdef MESHES
        place = mesh_ray_place(path.random.z);
#endif
        camera_ray(path.origin.xy + place, path.origin, path.direction);
    }
#endif
    if (path.stage == PATH_SCATTER) {
        vec3 next = sample_phase(g, path.direction, xi.xy);
        path.pdf = phase(g, dot(path.direction, next));
        path.direction = next;
    }
    path.depth = depth_of(xi.z);
    path.chance = xi.w;
    path.stage = PATH_FLIGHT;
}

/// Sends a shadow ray from `position` for `scattered` = throughput times what of the light goes on
/// along the path per irradiance; `pdf`: density of the same direction if the flight had chosen it.
/// The path follows it with stage `next`, if anything is left of it.
void leave(inout Path path, vec3 position, LightSample light, vec3 scattered, float pdf, uint next) {
    float weight = light.pdf > 0.0 ? light.pdf / (light.pdf + pdf) : 1.0;
    path.pending = scattered * light.radiance * weight;
    path.to_light = light.direction;
    path.transmittance = 1.0;
#ifdef MESHES
    path.pdf = light.distance;
#endif
    path.origin = position;
    path.t = -1.0;
    path.search = 0.0;
    path.stage = greatest_of(path.throughput) > 0.0 ? next : PATH_ENDED;
    if (greatest_of(path.pending) > 0.0) path.stage |= PATH_SHADOW;
}

/// Russian roulette: `xi` uniform in (0, 1).
void play_roulette(inout Path path, float xi) {
    float survival = min(greatest_of(path.throughput) / kRouletteThroughput, 1.0);
    path.throughput = xi < survival ? path.throughput / survival : vec3(0.0);
}

/// A real collision at `position`; `xi`: uniform in (0, 1).
void meet_medium(inout Path path, vec3 position, Medium medium, float xi) {
#ifndef CELLS
    if (path.bounces == 0u) {
        path.throughput *= constants.volume_gain;
#ifdef MESHES
        ++hidden_ends;
#endif
    }
#endif
#ifdef EMISSION
    path.radiance += path.throughput * (1.0 - medium.albedo) * medium.emitted;
#endif
    path.throughput *= medium.albedo;
    ++path.bounces;
    if (path.bounces > constants.max_bounces) path.throughput = vec3(0.0);
#ifdef GATHER
    if (path.bounces > 1u) {
        uint charged = kLookupIterations; // by advance()
        vec3 arriving = cached_in_scatter(unit_from_world(position), path.direction, charged);
        path.radiance += path.throughput * arriving;
        path.stage = PATH_ENDED;
        return;
    }
#endif
    LightSample light = light_at(path, position, vec3(0.0));
    float towards = phase(constants.phase_g, dot(path.direction, light.direction));
    vec3 scattered = path.throughput * towards;
    play_roulette(path, xi);
    leave(path, position, light, scattered, towards, PATH_SCATTER);
}

#ifdef SURFACES
/// A flight meets the surface of `hit`. xi: uniform, for the roulette.
void meet_surface(inout Path path, SurfaceHit hit, float xi) {
    vec3 view = -path.direction;
    vec3 normal = facing_normal(hit, view);
    vec3 position = off_surface(path.origin + path.t * path.direction, normal, normal);
#if defined(MESHES) && !defined(CELLS)
    if (path.bounces == 0u && !is_ray_end(hit)) ++hidden_ends;
#endif
#ifdef PATH
    if (path.bounces == 0u) path.throughput *= constants.surface_gain;
    ++path.bounces;
    if (path.bounces > constants.max_bounces) path.throughput = vec3(0.0);
    IsoMaterial material = frame.data.surfaces[hit.surface].material;
    LightSample light = light_at(path, position, vec3(0.0));
    vec3 scattered =
        path.throughput * evaluate_iso(material, constants.shading, normal, view, light.direction);
    float pdf = light.pdf > 0.0 ? pdf_iso(material, constants.shading, normal, view, light.direction) : 0.0;
    vec3 next;
    path.throughput *= sample_iso(material, constants.shading, normal, view, draw(path, SET_DIRECTION),
        next, path.pdf);
    play_roulette(path, xi);
    path.direction = next;
    leave(path, position, light, scattered, pdf, PATH_FLIGHT);
#else
    path.stage = PATH_ENDED;
#ifndef CELLS
    if (path.bounces == 0u) { // local shading: its shadow ray is the path's last
        path.throughput *= constants.surface_gain;
        path.radiance += path.throughput * reflected_environment(hit);
        vec3 scattered = path.throughput * reflected_light(hit, view);
#ifdef MESHES
        scattered *= sun_reaches(position);
#endif
        path.throughput = vec3(0.0);
        ++path.bounces;
        leave(path, position, LightSample(-constants.light_direction, vec3(1.0), 0.0, kInfinity), scattered,
            0.0, PATH_ENDED);
    }
#endif
#endif
}
#endif

#ifdef MESHES
/// A flight meets a triangle, which scatters evenly on the side that is met. xi: uniform.
void meet_mesh(inout Path path, MeshSearch search, vec2 xi) {
    MeshHit hit = mesh_hit(search, path.origin, path.direction);
    path.radiance += path.throughput * hit.emitted;
    path.throughput *= hit.albedo;
    ++path.bounces;
    if (path.bounces > constants.max_bounces) path.throughput = vec3(0.0);
    LightSample light = light_at(path, hit.position, hit.normal);
    vec3 scattered = path.throughput * (max(dot(hit.normal, light.direction), 0.0) / 3.14159265);

    vec4 turn = draw(path, SET_DIRECTION);
    vec3 tangent, bitangent;
    basis_around(hit.normal, tangent, bitangent);
    float azimuth = 6.28318531 * turn.y;
    path.direction = normalize(sqrt(turn.x) * (cos(azimuth) * tangent + sin(azimuth) * bitangent) +
        sqrt(1.0 - turn.x) * hit.normal);
    path.depth = depth_of(turn.z);
    path.chance = turn.w;
    // In a white room that nothing leaves, paths have to end as well.
    if (path.bounces > kLongPath) path.throughput *= xi.y < 0.9 ? 1.0 / 0.9 : 0.0;
    play_roulette(path, xi.x);
    leave(path, hit.position, light, scattered, 0.0, PATH_FLIGHT);
}
#endif

#ifdef CELLS
/// Mean incident radiance at a point of the box: as after a collision that scatters evenly and
/// absorbs nothing. Counts as a scattering. Inside an opaque solid it has ended, with 0.
Path begin_cell_path(vec3 position, Random random) {
    Path path = begin_path(position, PATH_SCATTER, random);
    path.bounces = 1u;
    depart(path);
    LightSample light = light_at(path, position, vec3(0.0));
    leave(path, position, light, vec3(path.pdf), path.pdf, PATH_FLIGHT);
    bool inside = constants.max_bounces > 0u;
#ifdef SURFACES
    float value = exact_field(unit_from_world(position));
    for (uint i = 0u; i < MAX_SURFACES; ++i) {
        if (i < constants.surface_count && frame.data.surfaces[i].opacity == 1.0)
            inside = inside && value < frame.data.surfaces[i].value;
    }
#endif
    if (!inside) path.stage = PATH_ENDED;
    return path;
}
#endif

/// How the present ray goes through the box; false: surfaces are still being searched for.
bool set_out(inout Path path, inout Tracker tracker, vec3 direction, bool shadow) {
    float near, far;
    vec3 entry_normal;
    bool inside = clip_ray(path.origin, direction, near, far, entry_normal);
#ifdef MESHES
    if (shadow) far = min(far, path.pdf);
    inside = inside && near < far;
#endif
#if defined(MESHES) && !defined(CELLS)
    if (path.bounces == 0u) { // from the camera: it is nowhere a shadow ray's
        uint pixel = path.random.y;
        float end = mesh_ray_end(ivec2(pixel % constants.size.x, pixel / constants.size.x), path.random.z);
        far = min(far, end);
        inside = inside && near < far;
    }
#endif
    if (!inside) near = far = 0.0;
    bool begins = path.t < 0.0;
    if (begins) path.t = near;
    tracker.flight.origin = unit_from_world(path.origin);
    tracker.flight.direction = unit_from_world_direction(direction);
#ifdef GRID
    tracker.flight.walk = walk_cells(tracker.flight.origin, tracker.flight.direction, near);
    if (begins) path.cell = pack_cell(tracker.flight.walk); // the search for surfaces may be interrupted
    tracker.flight.walk.cell = unpack_cell(path.cell);
#else
    tracker.flight.majorant = constants.majorant;
#endif
    tracker.flight.limit = far;
    tracker.ready = true;
#ifdef SURFACES
    tracker.hit.surface = kNoSurface;
    bool enters = path.search < near || path.search < 0.0; // a solid may begin right there
    float from = max(path.search, near);
#if defined(MESHES) && !defined(CELLS) && !defined(PATH)
    // The camera's ray ends at the first one that is opaque.
    bool ends_there = path.bounces == 0u;
    if (kIsoSamples && !kTranslucent && ends_there) from = far;
#endif
    if (from < far) {
        uint slice = kSearchSlice;
        bool found =
            find_surface(path.origin, direction, from, far, enters, entry_normal, slice, tracker.hit);
        if (!found && tracker.hit.t < far) { // the slice is used up
            path.search = tracker.hit.t;
            tracker.ready = false;
        }
#if defined(MESHES) && !defined(CELLS) && !defined(PATH)
        if (ends_there && is_ray_end(tracker.hit)) tracker.hit = SurfaceHit(far, kNoSurface, vec3(0.0), false);
#endif
        tracker.flight.limit = tracker.hit.t;
    }
#endif
    return tracker.ready;
}

/// Where a flight ends.
struct Meeting {
    uint what;   // MEETS_*
    float value; // of the field: the medium
    float xi;    // uniform: the medium and surfaces
#ifdef SURFACES
    SurfaceHit hit;
#endif
};
#define MEETS_NOTHING 0u
#define MEETS_MEDIUM 1u
#define MEETS_SURFACE 2u
#define MEETS_MESH 3u

/// Goes on with the present ray: where it leads, if that is not known, then some steps along it. True:
/// it has ended, a flight at `met`, a shadow ray with the path's transmittance.
bool travel(inout Path path, inout Tracker tracker, bool shadow, out Meeting met) {
    vec3 direction = shadow ? path.to_light : path.direction;
    if (!tracker.ready && !set_out(path, tracker, direction, shadow)) return false;

    float value = 0.0, chance = 1.0; // of the field, and that the collision is real
    bool collided = false, arrived = false; // for real; at a surface or where the medium ends
    for (uint i = 0u; i < kStride && !collided && !arrived; ++i) {
        bool tentative = fly(tracker.flight, path.t, path.depth);
        float likely = collision_chance(tracker.flight, path.t, value);
        if (tentative) {
            count_collision(likely);
            vec4 xi = draw_step(path);
            path.depth = depth_of(xi.x);
            if (shadow) {
                path.transmittance = ratio_tracked(path.transmittance, likely, xi.z);
                collided = path.transmittance == 0.0;
            } else {
                chance = min(likely, 1.0);
                collided = path.chance < chance;
                if (!collided) path.chance = xi.y;
            }
        }
        arrived = !tentative && path.t >= tracker.flight.limit;
    }
    if (!collided && !arrived) return false;
    tracker.ready = false;
    met.what = collided ? MEETS_MEDIUM : MEETS_NOTHING;
    met.value = value;
    met.xi = path.chance / chance;
#ifdef SURFACES
    met.hit = tracker.hit;
    if (arrived && tracker.hit.surface != kNoSurface) {
        float opacity = frame.data.surfaces[tracker.hit.surface].opacity;
        vec4 xi = draw_step(path);
        if (shadow) path.transmittance *= 1.0 - opacity;
        met.what = MEETS_SURFACE;
        met.xi = xi.y;
        if (shadow ? path.transmittance > 0.0 : xi.x >= opacity) { // goes on behind it
            path.search = tracker.hit.t + beyond_hit();
#ifdef GRID
            path.cell = pack_cell(tracker.flight.walk);
#endif
            return false;
        }
    }
#endif
    return true;
}

#ifdef MESHES
/// Keeps where a flight ends while meshes before it are looked for: PATH_MEETING. What it overwrites
/// is of shadow rays, of the way there, and drawn anew for the next ray.
void hold(inout Path path, Meeting met) {
    if (met.what == MEETS_NOTHING) path.t = kInfinity;
    path.stage = PATH_MEETING | met.what;
    path.chance = met.xi;
#ifdef SURFACES
    path.pending = met.hit.normal;
    path.to_light = vec3(uintBitsToFloat(met.hit.surface), met.hit.cut ? 1.0 : 0.0, 0.0);
#endif
    MeshSearch search = begin_mesh_search(path.t);
    path.cell = search.row;
    path.transmittance = search.t;
    path.depth = uintBitsToFloat(search.triangle);
}

/// Looks for meshes before the end of a flight, or of a shadow ray to a lamp, whose transmittance is 0
/// behind one. False: not everywhere yet. `met`: what a flight meets first.
bool look_for_meshes(inout Path path, bool shadow, out Meeting met, out MeshSearch search) {
    search = MeshSearch(path.cell, path.transmittance, floatBitsToUint(path.depth));
    if (shadow) search = MeshSearch(path.cell, path.pdf, MESH_END);
    bool ended = search_meshes(search, path.origin, shadow ? path.to_light : path.direction, path.random,
        shadow);
    path.cell = search.row;
    if (shadow) {
        if (search.triangle != MESH_END) path.transmittance = 0.0;
        return ended || path.transmittance == 0.0;
    }
    path.transmittance = search.t;
    // Where it ends, the depth is that of the next ray again.
    path.depth = ended ? depth_of(draw_step(path).x) : uintBitsToFloat(search.triangle);
    met.what = search.triangle != MESH_END ? MEETS_MESH : path.stage & ~PATH_MEETING;
    met.xi = path.chance;
    vec3 direction = unit_from_world_direction(path.direction);
    met.value = field(unit_from_world(path.origin) + min(path.t, 1e9) * direction);
#ifdef SURFACES
    met.hit = SurfaceHit(path.t, floatBitsToUint(path.to_light.x), path.pending, path.to_light.y > 0.0);
#endif
    return ended;
}
#endif

/// Goes on with a path that has not ended: along its present ray, then with what happens at its end.
/// All lanes do one after the other together.
void advance(inout Path path, inout Tracker tracker, inout uint budget) {
    budget -= min(budget, kAdvanceIterations);
    if (path.stage == PATH_CAMERA || path.stage == PATH_SCATTER) depart(path);
    bool shadow = (path.stage & PATH_SHADOW) != 0u;
    Meeting met;
#ifdef MESHES
    if (path.stage < PATH_MEETING) {
        if (!travel(path, tracker, shadow, met)) return;
        bool camera = path.bounces == 0u; // whose meshes are in the way already
        if (kMeshTree && !shadow && !camera) hold(path, met);
        bool lamp = kLamps > 0u && path.pdf < kInfinity;
        if (kMeshTree && shadow && lamp && path.transmittance > 0.0) {
            path.stage |= PATH_MEETING;
            path.cell = 0u;
        }
    }
    MeshSearch search;
    if (path.stage >= PATH_MEETING && !look_for_meshes(path, shadow && kLamps > 0u, met, search)) return;
#else
    if (!travel(path, tracker, shadow, met)) return;
#endif
    if (shadow) {
        path.radiance += path.pending * path.transmittance;
        path.stage &= ~(PATH_SHADOW | PATH_MEETING);
        path.t = -1.0;
        path.search = 0.0;
    } else if (met.what == MEETS_MEDIUM) {
        meet_medium(path, path.origin + path.t * path.direction, medium_of(met.value), met.xi);
#ifdef SURFACES
    } else if (met.what == MEETS_SURFACE) {
        meet_surface(path, met.hit, met.xi);
#endif
#ifdef MESHES
    } else if (met.what == MEETS_MESH) {
        meet_mesh(path, search, draw_step(path).xy);
#endif
    } else {
        vec3 arriving = escaped_radiance(path.direction, path.pdf);
#if defined(MESHES) && !defined(CELLS)
        if (path.bounces == 0u) arriving = vec3(0.0); // meshes and background have their picture
#endif
        path.radiance += path.throughput * arriving;
        path.stage = PATH_ENDED;
    }
}

#endif

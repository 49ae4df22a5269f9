// SPDX-License-Identifier: Apache-2.0
// reads the medium, the cache of light, surfaces; adds a sample of each pixel to compose_sum and
// writes the mean of all: radiance, and 1 - transmittance.
//   L += T (1 - exp(-sigma h)) (albedo in_scatter + (1 - albedo) Le),  T *= exp(-sigma h)
// front to back (Levoy 1988, Max 1995), over steps of length h with a jittered position each. Cells
// that nothing fills are skipped. Ends where the box does, at an opaque surface, or at opacity
// 1 - 1/512. A ray that uses up its loop budget is kept and goes on in the next dispatch.
//   DEPTH_IMAGE  the first surface comes from surface_depth, for rays through pixel centres
//   MESHES       ends at meshes as well, and writes the change of their picture: volume/meshes.glsl
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "volume/medium.glsl"
#include "volume/cells.glsl"
#include "include/random.glsl"
#include "volume/environment.glsl"
#ifdef SURFACES
#include "volume/surface.glsl"
#include "include/iso_bsdf.glsl"
#include "volume/shade_surface.glsl"
#endif
#include "volume/cache_lookup.glsl"
#ifdef MESHES
#include "volume/meshes.glsl"
#endif
#include "volume/compose.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 10, rgba32f) uniform image2D compose_sum;
layout(binding = 11, r32ui) uniform uimage2D compose_count; // samples * 2 + (1: a ray is under way)
layout(binding = 12, rgba32ui) uniform uimage2DArray compose_state; // of that ray, three layers
layout(binding = 13, rgba32f) uniform writeonly image2D composed;
#ifdef DEPTH_IMAGE
layout(binding = 14, rg32f) uniform readonly image2D surface_depth;
#endif
layout(push_constant, scalar) uniform Push { ComposePush push; };

const float kOpaque = 1.0 / 512.0; // transmittance that ends a ray
const int kSteps = 4;              // per lookup in the cache
const float kFinest = 8.0;         // times a step may be shortened for its optical depth
const float kGolden = 0.618033989; // jitters of successive steps fill [0, 1) evenly

struct Ray {
    vec3 origin; // world
    vec3 direction;
    vec3 unit_origin;
    vec3 unit_direction;
    float near;
    float far;
    vec3 entry_normal;
};

/// What is known of a ray when it is interrupted. 48 bytes.
struct Composition {
    vec3 radiance;
    float transmittance;
    float t;      // composed up to here
    float search; // no surface from the last one to here
    float jitter; // of the last step
    uint cell;    // where t is, packed; while shading, where the shadow ray is
    uint set;     // of random numbers
    uint stage;   // STAGE_*
    float seen;   // of the light, while shading
    float seen_t;
};
#define STAGE_MEDIUM 0u        // next is the medium in front of the next surface
#define STAGE_SHADE_SURFACES 1u // visibility of the light from the surface: other surfaces
#define STAGE_SHADE_MEDIUM 2u  // ... the medium

Composition load_state(ivec2 pixel) {
    uvec4 a = imageLoad(compose_state, ivec3(pixel, 0)), b = imageLoad(compose_state, ivec3(pixel, 1)),
          c = imageLoad(compose_state, ivec3(pixel, 2));
    vec4 x = uintBitsToFloat(a), y = uintBitsToFloat(b), z = uintBitsToFloat(c);
    return Composition(x.xyz, x.w, y.x, y.y, y.z, b.w, c.x, c.y, z.z, z.w);
}
void store_state(ivec2 pixel, Composition c) {
    imageStore(compose_state, ivec3(pixel, 0), floatBitsToUint(vec4(c.radiance, c.transmittance)));
    imageStore(compose_state, ivec3(pixel, 1),
        uvec4(floatBitsToUint(vec3(c.t, c.search, c.jitter)), c.cell));
    imageStore(compose_state, ivec3(pixel, 2),
        uvec4(c.set, c.stage, floatBitsToUint(vec2(c.seen, c.seen_t))));
}

/// 1 - exp(-tau), with its relative precision where tau is small; drivers' exp is good to 1e-7.
float opacity_of(float tau) {
    float series = tau * (1.0 - tau * (0.5 - tau * (1.0 / 6.0 - tau * (1.0 / 24.0))));
    return tau < 0.03 ? series : 1.0 - exp(-tau);
}

/// Composes the medium up to `end`, or to opacity. False: the budget is used up.
bool march(inout Composition c, Ray ray, float end, inout uint budget) {
    // World length of a step: a share of the voxels that the ray crosses per world unit.
    float longest = push.step_voxels / length(ray.unit_direction * vec3(frame.data.dims));
    CellWalk walk = resume_walk(ray.unit_origin, ray.unit_direction, c.cell);
    while (c.t < end && c.transmittance >= kOpaque && budget > 0u) {
        float exit = 0.0, majorant = 0.0;
        bool skip = true;
        while (skip && c.t < end && budget > 0u) {
            --budget;
            majorant = enter_cell(walk);
            exit = min(majorant_exit(walk), end);
            skip = majorant <= 0.0 || exit <= c.t;
            if (skip) {
                c.t = max(c.t, exit);
                next_cell(walk);
            }
        }
        if (skip) break;
        // A few steps, then one look at the light: at their centre of scattering, which is right to
        // second order.
        float step_length = max(min(longest, push.step_depth / majorant), longest / kFinest);
        float looks = max(ceil((exit - c.t) / (float(kSteps) * step_length) - 0.001), 1.0);
        float span = (exit - c.t) / looks;
        float h = span / float(kSteps);
        vec3 scattering = vec3(0.0), emitted = vec3(0.0);
        float weight = 0.0, centre = 0.0;
        for (int i = 0; i < kSteps; ++i) {
            if (push.jitter != 0u) c.jitter = fract(c.jitter + kGolden);
            float offset = (float(i) + c.jitter) * h;
            Medium medium = medium_of(field(ray.unit_origin + (c.t + offset) * ray.unit_direction));
            float w = c.transmittance * opacity_of(medium.sigma_t * h);
            c.transmittance -= w;
            scattering += w * medium.albedo;
#ifdef EMISSION
            emitted += w * (1.0 - medium.albedo) * medium.emitted;
#endif
            weight += w;
            centre += w * offset;
        }
        if (weight > 0.0) {
            vec3 unit = ray.unit_origin + (c.t + centre / weight) * ray.unit_direction;
            vec3 light = cached_in_scatter(unit, ray.direction, budget);
            c.radiance += frame.data.volume_gain * (scattering * light + emitted);
        }
        c.t = looks > 1.0 ? c.t + span : exit;
        budget -= min(budget, uint(kSteps) + 1u);
    }
    c.cell = pack_cell(walk);
    return c.t >= end || c.transmittance < kOpaque;
}

#ifdef SURFACES
/// The next surface. False: there is none, hit.t = ray.far; or the budget is used up before.
bool find_next(Composition c, Ray ray, ivec2 pixel, inout uint budget, out SurfaceHit hit) {
#ifdef MESHES
    SurfaceHit end = SurfaceHit(ray.far, kNoSurface, vec3(0.0), false);
    hit = end;
    if (kIsoSamples && !kTranslucent) return false;
#endif
    bool first = c.search == ray.near;
#ifdef DEPTH_IMAGE
    if (first) {
        vec2 found = imageLoad(surface_depth, pixel).xy;
        bool met = found.y > 0.0, cut = found.x == 0.0;
        hit.t = met ? mix(ray.near, ray.far, found.x) : ray.far;
        hit.surface = met ? uint(found.y) - 1u : kNoSurface;
        hit.cut = cut;
        hit.normal = cut && ray.entry_normal != vec3(0.0)
            ? ray.entry_normal
            : surface_normal(ray.unit_origin + hit.t * ray.unit_direction, ray.direction);
        return met;
    }
#endif
    bool met = find_surface(ray.origin, ray.direction, c.search, ray.far, first, ray.entry_normal, budget, hit);
#ifdef MESHES
    if (is_ray_end(hit)) {
        hit = end;
        met = false;
    }
#endif
    return met;
}

/// What the surface at `hit` hides of what is behind, and shows. False: the budget is used up.
bool shade(inout Composition c, Ray ray, SurfaceHit hit, inout Random random, inout uint budget) {
    vec3 view = -ray.direction;
    Visibility seen = begin_visibility();
    if (c.stage != STAGE_MEDIUM) {
        seen = Visibility(c.seen, c.seen_t, c.cell, c.stage == STAGE_SHADE_MEDIUM);
    }
    vec3 light = reflected_light(hit, view);
#ifdef MESHES
    light *= sun_reaches(ray.origin + hit.t * ray.direction);
#endif
    bool lit = any(greaterThan(light, vec3(0.0)));
    if (lit && !advance_visibility(seen, shadow_origin(hit, ray.origin + hit.t * ray.direction),
                   random, budget)) {
        c.stage = seen.medium ? STAGE_SHADE_MEDIUM : STAGE_SHADE_SURFACES;
        c.seen = seen.value;
        c.seen_t = seen.t;
        c.cell = seen.cell;
        return false;
    }
    float opacity = frame.data.surfaces[hit.surface].opacity;
    c.radiance += c.transmittance * opacity * frame.data.surface_gain *
                  (light * seen.value + reflected_environment(hit));
    c.transmittance *= 1.0 - opacity;
    c.t = c.search = hit.t + beyond_hit();
    c.cell = pack_cell(walk_cells(ray.unit_origin, ray.unit_direction, c.t));
    c.stage = STAGE_MEDIUM;
    return true;
}
#endif

/// Goes on with a ray to its end. False: the budget is used up before.
bool compose(inout Composition c, Ray ray, ivec2 pixel, inout Random random, inout uint budget) {
    bool ended = false, paused = false;
    while (!ended && !paused) {
        budget = max(budget, 2u) - 1u; // each call gets somewhere
        bool met = false;
        float end = ray.far;
#ifdef SURFACES
        SurfaceHit hit;
        met = find_next(c, ray, pixel, budget, hit);
        end = hit.t;
        paused = !met && end < ray.far;
        if (paused) c.search = end;
#endif
        budget = max(budget, 1u);
        if (!paused) paused = !march(c, ray, end, budget);
        ended = !paused && (!met || c.transmittance < kOpaque);
#ifdef SURFACES
        if (!paused && !ended) {
            budget = max(budget, 1u);
            paused = !shade(c, ray, hit, random, budget);
            ended = !paused && (c.transmittance < kOpaque || c.t >= ray.far);
        }
        paused = paused || (!ended && budget == 0u);
#endif
    }
    return ended;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(uvec2(pixel), frame.data.size))) return;
    uint count = imageLoad(compose_count, pixel).x;
    uint samples = count >> 1u;
    if (push.begins == 0u && (count & 1u) == 0u) {
        imageStore(composed, pixel, imageLoad(compose_sum, pixel) / float(max(samples, 1u)));
        return;
    }

    Random random = make_random(frame.data.seed, uint(pixel.y) * frame.data.size.x + uint(pixel.x), samples);
    vec4 xi = next4(random);
    vec2 place = push.jitter != 0u ? xi.xy : vec2(0.5);
#ifdef DEPTH_IMAGE
    place = vec2(0.5);
#endif
#ifdef MESHES
    place = mesh_ray_place(samples);
#endif
    Ray ray;
    camera_ray(vec2(pixel) + place, ray.origin, ray.direction);
    ray.unit_origin = unit_from_world(ray.origin);
    ray.unit_direction = unit_from_world_direction(ray.direction);
    bool inside = clip_ray(ray.origin, ray.direction, ray.near, ray.far, ray.entry_normal);
    vec3 behind = environment_radiance(ray.direction);
#ifdef MESHES
    ray.far = min(ray.far, mesh_ray_end(pixel, samples));
    inside = inside && ray.near < ray.far;
    behind = vec3(0.0);
#endif

    Composition c = Composition(vec3(0.0), 1.0, ray.near, ray.near, push.jitter != 0u ? xi.z : 0.5,
        pack_cell(walk_cells(ray.unit_origin, ray.unit_direction, ray.near)), random.set,
        STAGE_MEDIUM, 1.0, 0.0);
    if ((count & 1u) != 0u) c = load_state(pixel);
    random.set = c.set;

    uint budget = push.iterations;
    bool done = !inside || compose(c, ray, pixel, random, budget);

    vec4 so_far = vec4(c.radiance + c.transmittance * behind,
        1.0 - c.transmittance);
    // What an opaque ray did not reach would look like what it has met.
    if (c.transmittance < kOpaque) so_far = vec4(c.radiance / (1.0 - c.transmittance), 1.0);
#ifdef MESHES
    so_far.rgb -= so_far.a * mesh_ray_radiance(pixel, samples);
#endif
    vec4 sum = imageLoad(compose_sum, pixel);
    if (done) {
        sum += so_far;
        ++samples;
        imageStore(compose_sum, pixel, sum);
    } else {
        c.set = random.set;
        store_state(pixel, c);
    }
    imageStore(compose_count, pixel, uvec4(samples << 1u | uint(!done)));
    imageStore(composed, pixel, samples > 0u ? sum / float(samples) : so_far);
}

// SPDX-License-Identifier: Apache-2.0
// reads frame, volume, ranges; writes where the ray through each pixel's centre first meets an
// isosurface: x, as a fraction of its way through the box from `near` to `far`, and y, 1 + the
// surface; (1, 0) where it meets none. A ray that begins in the solid meets it at 0.
//   EXACT       the root of the cubic in the first cell that has one
//   MARCH       samples at (i + xi) / n and both ends; the first pair that a value lies between is bisected
//   STOCHASTIC  xi ~ U(0, G); V(xi) >= isovalue ? G = xi; G = 1 at first, kept between executions.
//               Algorithm 1 of the paper, but that G is not reset in between, and that a hit is a
//               hit, at the far end too. Of several surfaces it finds the outermost.
// Filters of hardware have weights of 8 bits: what MARCH samples with them, it confirms and bisects
// without; STOCHASTIC takes them as they are.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "volume/medium.glsl"
#include "include/random.glsl"
#include "volume/surface.glsl"
#include "volume/surface_depth.h"

layout(local_size_x = 8, local_size_y = 8) in;

#ifndef EXACT
layout(push_constant, scalar) uniform Push { SurfaceDepthPush push; };
#endif
#ifdef STOCHASTIC
layout(binding = 10, rg32f) uniform image2D surface_depth;
layout(binding = 11, r32ui) uniform uimage2D candidates; // tried so far
#else
layout(binding = 10, rg32f) uniform writeonly image2D surface_depth;
#endif

const vec2 kMiss = vec2(1.0, 0.0);

#ifdef EXACT
vec2 search(vec3 origin, vec3 direction, float near, float far, vec3 entry_normal, ivec2 pixel) {
    SurfaceHit hit;
    uint budget = ~0u; // a ray crosses fewer cells than the box has along its three axes together
    if (!find_surface(origin, direction, near, far, true, entry_normal, budget, hit)) return kMiss;
    return vec2((hit.t - near) / (far - near), 1.0 + float(hit.surface));
}
#else
float uniform_of(ivec2 pixel, uint index) {
    Random random = make_random(frame.data.seed, uint(pixel.y) * frame.data.size.x + uint(pixel.x), index);
    return next4(random).x;
}
#endif

#ifdef MARCH
vec2 search(vec3 origin, vec3 direction, float near, float far, vec3 entry_normal, ivec2 pixel) {
    vec3 first = unit_from_world(origin + near * direction);
    vec3 all = unit_from_world(origin + far * direction) - first;
    vec4 values = isovalues();
    float xi = uniform_of(pixel, 0u), before = field(first), low = 0.0, high = 0.0;
    uint around = surface_around(values, before);
    if (around != kNoSurface) return vec2(0.0, 1.0 + float(around));

    bool crossed = false;
    for (uint i = 0u; i <= push.steps && !crossed; ++i) {
        low = high;
        high = min((float(i) + xi) / float(push.steps), 1.0);
        vec3 sampled = first + high * all;
        crossed = surface_around(values, field(sampled)) != kNoSurface;
        if (crossed) crossed = surface_around(values, exact_field(sampled)) != kNoSurface;
    }
    if (!crossed) return kMiss;
    around = 0u;
    for (uint i = 0u; i < 20u; ++i) {
        float middle = 0.5 * (low + high);
        uint found = surface_around(values, exact_field(first + middle * all));
        if (found == kNoSurface) {
            low = middle;
        } else {
            high = middle;
            around = found;
        }
    }
    return vec2(high, 1.0 + float(around));
}
#endif

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(frame.data.size)))) return;
    vec3 origin, direction, entry_normal;
    float near, far;
    camera_ray(vec2(pixel) + 0.5, origin, direction);
    bool inside = clip_ray(origin, direction, near, far, entry_normal);

#ifdef STOCHASTIC
    if (!inside) return; // as cleared
    vec3 first = unit_from_world(origin + near * direction);
    vec3 all = unit_from_world(origin + far * direction) - first;
    vec4 values = isovalues();
    float outermost = least(values);
    vec2 state = imageLoad(surface_depth, pixel).xy;
    uint tried = imageLoad(candidates, pixel).x;
    uint around = surface_around(values, field(first));
    if (around != kNoSurface) state = vec2(0.0, 1.0 + float(around));
    for (uint i = 0u; i < push.steps && state.x > 0.0; ++i) {
        float candidate = uniform_of(pixel, tried + i) * state.x;
        if (field(first + candidate * all) >= outermost)
            state = vec2(candidate, 1.0 + float(surface_of(values, outermost)));
    }
    imageStore(surface_depth, pixel, vec4(state, 0.0, 0.0));
    imageStore(candidates, pixel, uvec4(tried + push.steps));
#else
    vec2 found = inside ? search(origin, direction, near, far, entry_normal, pixel) : kMiss;
    imageStore(surface_depth, pixel, vec4(found, 0.0, 0.0));
#endif
}

// SPDX-License-Identifier: Apache-2.0
// The light that a path finds: sampled at its collisions, or met where it leaves the box. An
// environment map is both, weighed by the balance heuristic; a directional light is always sampled,
// a constant environment always met.
#ifndef OCKHAM_VOLUME_LIGHT_GLSL
#define OCKHAM_VOLUME_LIGHT_GLSL

#include "volume/environment.glsl"

#ifndef PATH_NEE // whether the environment map is sampled at collisions
#define PATH_NEE true
#endif

float greatest_of(vec3 v) { return max(max(v.x, v.y), v.z); }

/// Light chosen at a collision: one of the directional light and the environment map.
struct LightSample {
    vec3 direction; // towards it
    vec3 radiance;  // over the chance to choose it, and over its density where it has one
    float pdf;      // density, with that chance; 0: a light from one direction only
    float distance; // world units
};

/// Chance that the directional light is chosen.
float directional_share() {
#ifdef ENVIRONMENT_MAP
    if (!PATH_NEE) return 1.0;
    return greatest_of(constants.light_irradiance) > 0.0 ? 0.5 : 0.0;
#else
    return 1.0;
#endif
}

/// `xi`: uniform in (0, 1).
LightSample sample_light(vec4 xi) {
#ifdef ENVIRONMENT_MAP
    float share = directional_share();
    if (xi.x >= share) {
        LightSample light;
        light.radiance = sample_environment(xi.yz, light.direction, light.pdf);
        light.pdf *= 1.0 - share;
        light.radiance = light.pdf > 0.0 ? light.radiance / light.pdf : vec3(0.0);
        light.distance = kInfinity;
        return light;
    }
    return LightSample(-constants.light_direction, constants.light_irradiance / share, 0.0, kInfinity);
#else
    return LightSample(-constants.light_direction, constants.light_irradiance, 0.0, kInfinity);
#endif
}

/// Radiance from where a ray leaves for good, whose direction was drawn with density `pdf`; < 0: no
/// sampled light competes with it. Balance heuristic against sample_light().
vec3 escaped_radiance(vec3 direction, float pdf) {
    vec3 radiance = environment_radiance(direction);
#ifdef ENVIRONMENT_MAP
    if (PATH_NEE && pdf >= 0.0)
        radiance *= pdf / (pdf + (1.0 - directional_share()) * environment_pdf_of(radiance));
#endif
    return radiance;
}

#endif

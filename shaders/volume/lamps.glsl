// SPDX-License-Identifier: Apache-2.0
// Point and spot lights, which light a medium as framework/scene/light.hpp has it.
//   reads lights: those of the scene, directional ones first, then points, then spots
// Include after volume/light.glsl.
#ifndef OCKHAM_VOLUME_LAMPS_GLSL
#define OCKHAM_VOLUME_LAMPS_GLSL

#include "include/attenuation.glsl"
#include "volume/meshes.h"

layout(constant_id = SPEC_FIRST_LAMP) const uint kFirstLamp = 0u; // of the scene's lights
layout(constant_id = SPEC_LAMPS) const uint kLamps = 0u;          // points and spots; 0: other data stand in
layout(constant_id = SPEC_SPOTS) const uint kSpots = 0u;          // the last of them

layout(scalar, binding = 20) readonly buffer Lights { LightData items[]; } lights;

/// One of them, each as likely, chosen with the probability `share` beside other light; xi in (0, 1).
LightSample sample_lamp(vec3 position, float xi, float share) {
    uint lamp = min(uint(xi * float(kLamps)), kLamps - 1u);
    LightData light = lights.items[kFirstLamp + lamp];
    vec3 way = light.position - position;
    float distance2 = dot(way, way);
    vec3 direction = way * inversesqrt(max(distance2, 1e-12));
    float cone = clamp(dot(direction, light.to_light) * light.cone_scale + light.cone_offset, 0.0, 1.0);
    if (lamp < kLamps - kSpots) cone = 1.0;
    vec3 irradiance = light.intensity * (attenuation(light, distance2) * cone * cone);
    return LightSample(direction, irradiance * (float(kLamps) / share), 0.0, sqrt(distance2));
}

#endif

// SPDX-License-Identifier: Apache-2.0
// How light of a point or spot light falls off (framework/scene/light.hpp).
#ifndef OCKHAM_ATTENUATION_GLSL
#define OCKHAM_ATTENUATION_GLSL

#include "shared/scene.h"

/// Distance fall-off and window.
float attenuation(LightData light, float distance2) {
    float x = distance2 * light.inverse_range_squared;
    float window = max(1.0 - (light.window_half_power > 1.0 ? x * x : x), 0.0);
    return window / max(distance2 + light.softening, 1e-6);
}

#endif

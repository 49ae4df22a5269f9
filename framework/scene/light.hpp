// SPDX-License-Identifier: Apache-2.0
// Punctual lights: KHR_lights_punctual and the lights of rig files in one form.
#pragma once

#include <glm/glm.hpp>

#include <cstdint>
#include <limits>
#include <string>

namespace ockham {

enum class LightType : std::uint32_t { directional, point, spot };

/// Light arriving at distance d: intensity * window(d) / (d^2 + softening), where
/// window(d) = max(0, 1 - (d / range)^window_power) (1 for an infinite range); a spot also
/// fades from its inner to its outer cone as KHR_lights_punctual does.
struct Light {
    std::string name;
    LightType type = LightType::point;
    glm::vec3 position{0.0f};               ///< world; point and spot
    glm::vec3 direction{0.0f, -1.0f, 0.0f}; ///< unit, the way light travels; directional and spot
    /// Directional: irradiance on a surface that faces the light. Point, spot: radiant intensity.
    glm::vec3 intensity{1.0f};
    float range = std::numeric_limits<float>::infinity(); ///< world units, > 0
    float window_power = 4.0f;                            ///< 4 for glTF, 2 for rigs
    float softening = 0.0f;  ///< world units squared; 0 for glTF, 0.1 for rigs
    float inner_cone = 0.0f; ///< radians from the axis
    float outer_cone = 0.785398f;
    bool casts_shadow = false; ///< honoured for the main (first directional) light
};

} // namespace ockham

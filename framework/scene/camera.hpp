// SPDX-License-Identifier: Apache-2.0
// A pinhole or orthographic camera in world space, and the matrix that rasterises it with
// reversed depth. Plain data; scenes carry several, programs pick one.
#pragma once

#include <glm/glm.hpp>

#include <string>

namespace ockham {

struct Camera {
    std::string name;
    glm::vec3 position{0.0f, 0.0f, 0.0f};
    glm::vec3 forward{0.0f, 0.0f, -1.0f}; ///< unit length
    glm::vec3 up{0.0f, 1.0f, 0.0f};       ///< unit length, perpendicular to `forward`
    float fov_y_degrees = 60.0f;          ///< vertical, (0, 180); unused when orthographic
    float orthographic_height = 0.0f;     ///< world units from bottom to top; 0 = perspective
};

enum class UpAxis { y, z };

/// Camera at `position` looking at `target`. Up is the axis given, or the other one of y and z
/// where the view runs along it. `position` and `target` must differ.
Camera look_at(glm::vec3 position, glm::vec3 target, float fov_y_degrees, UpAxis up = UpAxis::y);

/// The camera carried around the axis `up` through `centre`, counter-clockwise as seen from above.
Camera turned(const Camera& camera, glm::vec3 centre, UpAxis up, float radians);

} // namespace ockham

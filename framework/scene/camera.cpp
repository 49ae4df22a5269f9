// SPDX-License-Identifier: Apache-2.0
#include "framework/scene/camera.hpp"

#include "framework/core/error.hpp"

#include <cmath>

namespace ockham {

Camera look_at(glm::vec3 position, glm::vec3 target, float fov_y_degrees) {
    check(position != target, "look_at: position and target are the same point");
    Camera camera;
    camera.position = position;
    camera.forward = glm::normalize(target - position);
    camera.fov_y_degrees = fov_y_degrees;
    const bool along_y = std::abs(camera.forward.y) > 0.9999f;
    const glm::vec3 reference = along_y ? glm::vec3(0.0f, 0.0f, 1.0f) : glm::vec3(0.0f, 1.0f, 0.0f);
    const glm::vec3 right = glm::normalize(glm::cross(camera.forward, reference));
    camera.up = glm::cross(right, camera.forward);
    return camera;
}

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
#include "framework/scene/camera.hpp"

#include "framework/core/error.hpp"

#include <glm/gtc/matrix_transform.hpp>

#include <cmath>

namespace ockham {

namespace {

glm::vec3 direction_of(UpAxis axis) {
    return axis == UpAxis::y ? glm::vec3(0.0f, 1.0f, 0.0f) : glm::vec3(0.0f, 0.0f, 1.0f);
}

} // namespace

Camera look_at(glm::vec3 position, glm::vec3 target, float fov_y_degrees, UpAxis up) {
    check(position != target, "look_at: position and target are the same point");
    Camera camera;
    camera.position = position;
    camera.forward = glm::normalize(target - position);
    camera.fov_y_degrees = fov_y_degrees;
    const bool along = std::abs(glm::dot(camera.forward, direction_of(up))) > 0.9999f;
    const UpAxis other = up == UpAxis::y ? UpAxis::z : UpAxis::y;
    const glm::vec3 reference = direction_of(along ? other : up);
    const glm::vec3 right = glm::normalize(glm::cross(camera.forward, reference));
    camera.up = glm::cross(right, camera.forward);
    return camera;
}

Camera turned(const Camera& camera, glm::vec3 centre, UpAxis up, float radians) {
    const glm::mat3 turn(glm::rotate(glm::mat4(1.0f), radians, direction_of(up)));
    Camera result = camera;
    result.position = centre + turn * (camera.position - centre);
    result.forward = turn * camera.forward;
    result.up = turn * camera.up;
    return result;
}

} // namespace ockham

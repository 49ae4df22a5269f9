// SPDX-License-Identifier: Apache-2.0
#include "samples/viewer/navigation.hpp"

#include <fmt/format.h>
#include <glm/gtc/constants.hpp>

#include <algorithm>
#include <cmath>

namespace ockham::viewer {
namespace {

constexpr float kSteepest = 1.55f; ///< radians; at a pole the view would have no up

} // namespace

void Navigation::reset(const Camera& camera, glm::vec3 pivot, float scale, UpAxis up) {
    camera_ = camera;
    scale_ = scale;
    up_ = up;
    // On the view's axis, as far as what it looks at.
    distance_ = glm::dot(pivot - camera.position, camera.forward);
    if (!(distance_ > 0.01f * scale)) distance_ = 0.5f * scale;
}

glm::vec3 Navigation::vertical() const {
    return up_ == UpAxis::y ? glm::vec3(0, 1, 0) : glm::vec3(0, 0, 1);
}

void Navigation::turn(float right, float up) {
    const glm::vec3 axis = vertical();
    // A frame that stands on the ground: forward at azimuth 0, its left, and the vertical.
    const glm::vec3 ahead = up_ == UpAxis::y ? glm::vec3(0, 0, -1) : glm::vec3(0, 1, 0);
    const glm::vec3 aside = glm::cross(ahead, axis); // to the right
    const glm::vec3 f = camera_.forward;
    float azimuth = std::atan2(glm::dot(f, aside), glm::dot(f, ahead));
    float elevation = std::asin(glm::clamp(glm::dot(f, axis), -1.0f, 1.0f));
    azimuth += right;
    elevation = glm::clamp(elevation + up, -kSteepest, kSteepest);
    camera_.forward =
        std::cos(elevation) * (std::cos(azimuth) * ahead + std::sin(azimuth) * aside) +
        std::sin(elevation) * axis;
    camera_.forward = glm::normalize(camera_.forward);
    const glm::vec3 sideways = glm::normalize(glm::cross(camera_.forward, axis));
    camera_.up = glm::cross(sideways, camera_.forward);
}

void Navigation::orbit(float right, float up) {
    const glm::vec3 pivot = camera_.position + distance_ * camera_.forward;
    turn(right, up);
    camera_.position = pivot - distance_ * camera_.forward;
}

void Navigation::look(float right, float up) { turn(right, up); }

void Navigation::pan(float right, float up) {
    const float height =
        camera_.orthographic_height > 0
            ? camera_.orthographic_height
            : 2.0f * distance_ * std::tan(0.5f * glm::radians(camera_.fov_y_degrees));
    const glm::vec3 sideways = glm::cross(camera_.forward, camera_.up);
    camera_.position += height * (right * sideways + up * camera_.up);
}

void Navigation::zoom(float factor) {
    if (camera_.orthographic_height > 0) {
        camera_.orthographic_height *= factor;
        return;
    }
    const float nearer = std::max(distance_ * factor, 1e-4f * scale_);
    camera_.position += (distance_ - nearer) * camera_.forward;
    distance_ = nearer;
}

void Navigation::walk(const glm::vec3& v) {
    const glm::vec3 sideways = glm::cross(camera_.forward, camera_.up);
    camera_.position += scale_ * (v.x * sideways + v.y * vertical() + v.z * camera_.forward);
}

std::string camera_text(const Camera& camera, float distance) {
    const glm::vec3 p = camera.position, t = p + distance * camera.forward;
    return fmt::format("{:.6g},{:.6g},{:.6g} {:.6g},{:.6g},{:.6g} {:.6g}", p.x, p.y, p.z, t.x, t.y,
        t.z, camera.fov_y_degrees);
}

} // namespace ockham::viewer

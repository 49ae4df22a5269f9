// SPDX-License-Identifier: Apache-2.0
#include "passes/surface/frame.hpp"

#include "framework/core/error.hpp"
#include "passes/surface/sample_order.hpp"

#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <cmath>

namespace ockham {
namespace {

/// Box around the bounds as seen along the sun, for one shadow map.
glm::mat4 sun_view_projection(const Bounds& bounds, glm::vec3 direction, int size, float& texel) {
    const glm::vec3 up = std::abs(direction.y) > 0.99f ? glm::vec3(0, 0, 1) : glm::vec3(0, 1, 0);
    const glm::vec3 right = glm::normalize(glm::cross(direction, up));
    const glm::vec3 top = glm::cross(right, direction);
    Bounds seen; // in the sun's axes: right, top, direction
    for (int corner = 0; corner < 8; ++corner) {
        const glm::vec3 p((corner & 1) ? bounds.high.x : bounds.low.x,
            (corner & 2) ? bounds.high.y : bounds.low.y,
            (corner & 4) ? bounds.high.z : bounds.low.z);
        seen.add({glm::dot(p, right), glm::dot(p, top), glm::dot(p, direction)});
    }
    const glm::vec3 margin(1e-3f * bounds.radius() + 1e-6f);
    const glm::vec3 low = seen.low - margin, high = seen.high + margin, extent = high - low;
    texel = std::max(extent.x, extent.y) / static_cast<float>(size);
    glm::mat4 m(0.0f); // columns
    for (int axis = 0; axis < 3; ++axis) {
        m[axis][0] = 2.0f * right[axis] / extent.x;
        m[axis][1] = 2.0f * top[axis] / extent.y;
        m[axis][2] = -direction[axis] / extent.z; // reversed: 1 nearest to the sun
    }
    m[3] = {-(low.x + high.x) / extent.x, -(low.y + high.y) / extent.y, high.z / extent.z, 1.0f};
    return m;
}

} // namespace

std::vector<std::uint32_t> paper_order(int m) { return sample_order(SampleOrder::paper, m); }

shader::FrameData make_frame(const Scene& scene, const Bounds& bounds, const Camera& camera,
    int width, int height, int m, const std::vector<std::uint32_t>& order, int shadow_map_size,
    const Bounds& others) {
    check(m >= 1 && m <= MAX_WINDOW && order.size() == static_cast<std::size_t>(m * m),
        "the order has one entry per sample of the window");
    const float aspect = static_cast<float>(width) / static_cast<float>(height);
    const bool orthographic = camera.orthographic_height > 0.0f;
    const float half_height = orthographic ? 0.5f * camera.orthographic_height
                                           : std::tan(0.5f * glm::radians(camera.fov_y_degrees));
    const glm::vec3 right = glm::normalize(glm::cross(camera.forward, camera.up));
    const glm::vec3 up = glm::cross(right, camera.forward);

    // Far enough to hold everything, near enough to touch nothing: reversed floating-point depth
    // resolves 6e-8 of the distance wherever the near plane stands.
    Bounds seen = bounds;
    if (!others.empty()) {
        seen.add(others.low);
        seen.add(others.high);
    }
    const float reach = glm::length(seen.center() - camera.position) + seen.radius();
    const float far_distance = std::max(1.01f * reach, 1e-3f);
    const float near_distance = 1e-6f * far_distance;

    shader::FrameData frame{};
    frame.position = camera.position;
    frame.right = right * half_height * aspect;
    frame.up = up * half_height;
    frame.forward = camera.forward;
    frame.near_distance = near_distance;
    frame.far_distance = far_distance;
    frame.background_depth = 2.0f * far_distance;
    frame.orthographic = orthographic ? 1u : 0u;
    frame.background = scene.background;
    frame.ambient = scene.ambient;
    frame.m = static_cast<std::uint32_t>(m);
    frame.size =
        frame.picture = {static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height)};
    std::copy(order.begin(), order.end(), frame.order);

    // Rows of the projection in terms of view coordinates (x right, y up, d forward).
    glm::mat4 view(0.0f);
    for (int axis = 0; axis < 3; ++axis) {
        view[axis][0] = right[axis];
        view[axis][1] = up[axis];
        view[axis][2] = camera.forward[axis];
    }
    view[3] = {-glm::dot(right, camera.position), -glm::dot(up, camera.position),
        -glm::dot(camera.forward, camera.position), 1.0f};
    glm::mat4 projection(0.0f);
    projection[0][0] = 1.0f / (half_height * aspect);
    projection[1][1] = -1.0f / half_height; // Vulkan's y points down
    if (orthographic) {
        projection[2][2] = -1.0f / far_distance;
        projection[3][2] = 1.0f;
        projection[3][3] = 1.0f;
    } else {
        projection[3][2] = near_distance; // z = near, w = depth: near / depth
        projection[2][3] = 1.0f;
    }
    frame.view_projection = projection * view;

    for (const Light& light : scene.lights) {
        frame.directional_count += light.type == LightType::directional ? 1u : 0u;
        frame.point_count += light.type == LightType::point ? 1u : 0u;
        frame.spot_count += light.type == LightType::spot ? 1u : 0u;
    }
    const auto sun = std::find_if(scene.lights.begin(), scene.lights.end(),
        [](const Light& light) { return light.type == LightType::directional; });
    frame.sun_projection = glm::mat4(1.0f);
    if (sun != scene.lights.end() && sun->casts_shadow && !bounds.empty()) {
        frame.sun_projection =
            sun_view_projection(bounds, sun->direction, shadow_map_size, frame.sun_texel);
    }
    return frame;
}

void set_jitter(shader::FrameData& frame, glm::vec2 jitter) {
    frame.jitter = jitter;
    const glm::vec2 ndc = 2.0f * jitter / glm::vec2(frame.picture * frame.m);
    for (int column = 0; column < 4; ++column) {
        glm::vec4& v = frame.view_projection[column];
        v.x -= ndc.x * v.w;
        v.y -= ndc.y * v.w; // clip space points down
    }
}

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
#include "framework/io/rig.hpp"

#include "framework/core/json_object.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>

namespace ockham {
namespace {

/// Fall-off of point lights in rig files.
constexpr float kWindowPower = 2.0f;
constexpr float kSoftening = 0.1f;

constexpr double kLargest = std::numeric_limits<float>::max();

glm::vec3 read_vector(const JsonObject& source, const char* key, double low, const char* expected) {
    const std::array<double, 3> v = source.numbers<3>(key, low, kLargest, expected);
    return {v[0], v[1], v[2]};
}

glm::vec3 read_position(const JsonObject& source, const char* key) {
    return read_vector(source, key, -kLargest, "three numbers");
}

glm::vec3 read_color(const JsonObject& source, const char* key) {
    return read_vector(source, key, 0.0, "three numbers of at least 0");
}

/// A vector of any length but zero.
glm::vec3 read_direction(const JsonObject& source, const char* key) {
    const glm::vec3 result = read_position(source, key);
    const float length = glm::length(result);
    if (!(length > 0.0f) || !std::isfinite(length)) source.refuse(key, "a direction");
    return result / length;
}

float read_number(
    const JsonObject& source, const char* key, double low, double high, const char* expected) {
    return static_cast<float>(source.number(key, low, high, expected));
}

Camera read_camera(const JsonObject& source) {
    source.warn_unknown({"position", "target", "fov_y_degrees"});
    const glm::vec3 position = read_position(source, "position");
    const glm::vec3 target = read_position(source, "target");
    if (position == target) source.refuse("target", "a point other than the position");
    const float fov = read_number(source, "fov_y_degrees", 0.01, 179.0, "degrees from 0.01 to 179");
    Camera camera = look_at(position, target, fov);
    camera.name = "rig";
    return camera;
}

Light read_sun(const JsonObject& source) {
    source.warn_unknown({"toward", "irradiance", "shadow"});
    Light light;
    light.name = "sun";
    light.type = LightType::directional;
    light.direction = -read_direction(source, "toward");
    light.intensity = read_color(source, "irradiance");
    light.casts_shadow = source.boolean("shadow", false);
    return light;
}

Light read_point(const JsonObject& source, std::size_t number) {
    source.warn_unknown({"position", "intensity", "range"});
    Light light;
    light.name = fmt::format("point {}", number);
    light.type = LightType::point;
    light.position = read_position(source, "position");
    light.intensity = read_color(source, "intensity");
    light.range = read_number(source, "range", 1e-6, 1e18, "a length above 0");
    light.window_power = kWindowPower;
    light.softening = kSoftening;
    return light;
}

} // namespace

Rig load_rig(const std::filesystem::path& path) {
    const nlohmann::json root = parse_json(path, "rig");
    const JsonObject source(root, "rig", path.string());
    source.warn_unknown({"camera", "background", "ambient", "sun", "points"});
    Rig rig;
    if (source.has("camera")) rig.camera = read_camera(source.object("camera"));
    if (source.has("background")) rig.background = read_color(source, "background");
    if (source.has("ambient")) rig.ambient = read_color(source, "ambient");
    if (source.has("sun")) rig.lights.push_back(read_sun(source.object("sun")));
    if (!source.has("points")) return rig;
    std::size_t number = 0;
    for (const JsonObject& point : source.objects("points")) {
        rig.lights.push_back(read_point(point, number++));
    }
    return rig;
}

void apply(const Rig& rig, Scene& scene) {
    if (rig.camera) scene.cameras.insert(scene.cameras.begin(), *rig.camera);
    if (rig.background) scene.background = *rig.background;
    if (rig.ambient) scene.ambient = *rig.ambient;
    if (!rig.lights.empty()) scene.lights = rig.lights;
}

} // namespace ockham

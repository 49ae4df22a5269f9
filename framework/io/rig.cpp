// SPDX-License-Identifier: Apache-2.0
#include "framework/io/rig.hpp"

#include "framework/core/error.hpp"
#include "framework/core/file.hpp"
#include "framework/core/log.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace ockham {
namespace {

using nlohmann::json;

constexpr std::size_t kMaxBytes = std::size_t{64} << 20;
/// Fall-off of point lights in rig files.
constexpr float kWindowPower = 2.0f;
constexpr float kSoftening = 0.1f;

/// One object of the file and its place in it ("points[3]"), for messages.
class RigObject {
public:
    RigObject(const json& value, std::string file, std::string place)
        : value_(value), file_(std::move(file)), place_(std::move(place)) {
        if (!value_.is_object()) refuse(place_.empty() ? "the rig" : place_, value_, "an object");
    }

    void warn_unknown(std::initializer_list<std::string_view> known) const {
        for (const auto& [key, value] : value_.items()) {
            if (std::find(known.begin(), known.end(), key) != known.end()) continue;
            log::warning("rig '{}': unknown key '{}' is ignored", file_, name(key));
        }
    }

    bool has(const char* key) const { return value_.contains(key); }
    RigObject object(const char* key) const { return {get(key), file_, name(key)}; }

    std::vector<RigObject> objects(const char* key) const {
        const json& list = get(key);
        if (!list.is_array()) refuse(name(key), list, "an array of objects");
        std::vector<RigObject> result;
        for (const json& item : list) {
            result.emplace_back(item, file_, fmt::format("{}[{}]", name(key), result.size()));
        }
        return result;
    }

    float number(const char* key, double low, double high, const char* expected) const {
        return number(get(key), name(key), low, high, expected);
    }

    bool boolean(const char* key, bool fallback) const {
        if (!has(key)) return fallback;
        const json& value = get(key);
        if (!value.is_boolean()) refuse(name(key), value, "true or false");
        return value.get<bool>();
    }

    glm::vec3 position(const char* key) const { return vector(key, -kLargest, "three numbers"); }
    glm::vec3 color(const char* key) const {
        return vector(key, 0.0, "three numbers of at least 0");
    }

    /// A vector of any length but zero.
    glm::vec3 direction(const char* key) const {
        const glm::vec3 result = position(key);
        const float length = glm::length(result);
        if (!(length > 0.0f) || !std::isfinite(length)) refuse(key, "a direction");
        return result / length;
    }

    [[noreturn]] void refuse(const char* key, const char* expected) const {
        refuse(name(key), get(key), expected);
    }

private:
    static constexpr double kLargest = std::numeric_limits<float>::max();

    std::string name(const std::string& key) const {
        return place_.empty() ? key : place_ + "." + key;
    }

    const json& get(const char* key) const {
        const auto found = value_.find(key);
        if (found == value_.end())
            fail_input("cannot load rig '{}': {} is missing", file_, name(key));
        return *found;
    }

    float number(const json& value, const std::string& place, double low, double high,
        const char* expected) const {
        const double found = value.is_number() ? value.get<double>() : NAN;
        if (!(found >= low && found <= high)) refuse(place, value, expected);
        return static_cast<float>(found);
    }

    glm::vec3 vector(const char* key, double low, const char* expected) const {
        const json& list = get(key);
        if (!list.is_array() || list.size() != 3) refuse(name(key), list, expected);
        glm::vec3 result;
        for (int i = 0; i < 3; ++i) result[i] = number(list[i], name(key), low, kLargest, expected);
        return result;
    }

    [[noreturn]] void refuse(
        const std::string& place, const json& found, const char* expected) const {
        const std::string text = found.dump(-1, ' ', true, json::error_handler_t::replace);
        fail_input("cannot load rig '{}': {} is {}, expected {}", file_, place, text.substr(0, 64),
            expected);
    }

    const json& value_;
    std::string file_;
    std::string place_;
};

json parse(const std::filesystem::path& path) {
    try {
        return json::parse(read_text(path, kMaxBytes));
    } catch (const json::exception& error) {
        const std::string reason = error.what();
        fail_input("cannot load rig '{}': not valid JSON: {}", path.string(),
            reason.substr(0, std::min<std::size_t>(reason.find('\n'), 160)));
    }
}

Camera read_camera(const RigObject& source) {
    source.warn_unknown({"position", "target", "fov_y_degrees"});
    const glm::vec3 position = source.position("position");
    const glm::vec3 target = source.position("target");
    if (position == target) source.refuse("target", "a point other than the position");
    const float fov = source.number("fov_y_degrees", 0.01, 179.0, "degrees from 0.01 to 179");
    Camera camera = look_at(position, target, fov);
    camera.name = "rig";
    return camera;
}

Light read_sun(const RigObject& source) {
    source.warn_unknown({"toward", "irradiance", "shadow"});
    Light light;
    light.name = "sun";
    light.type = LightType::directional;
    light.direction = -source.direction("toward");
    light.intensity = source.color("irradiance");
    light.casts_shadow = source.boolean("shadow", false);
    return light;
}

Light read_point(const RigObject& source, std::size_t number) {
    source.warn_unknown({"position", "intensity", "range"});
    Light light;
    light.name = fmt::format("point {}", number);
    light.type = LightType::point;
    light.position = source.position("position");
    light.intensity = source.color("intensity");
    light.range = source.number("range", 1e-6, 1e18, "a length above 0");
    light.window_power = kWindowPower;
    light.softening = kSoftening;
    return light;
}

} // namespace

Rig load_rig(const std::filesystem::path& path) {
    const json root = parse(path);
    const RigObject source(root, path.string(), "");
    source.warn_unknown({"camera", "background", "ambient", "sun", "points"});
    Rig rig;
    if (source.has("camera")) rig.camera = read_camera(source.object("camera"));
    if (source.has("background")) rig.background = source.color("background");
    if (source.has("ambient")) rig.ambient = source.color("ambient");
    if (source.has("sun")) rig.lights.push_back(read_sun(source.object("sun")));
    if (!source.has("points")) return rig;
    std::size_t number = 0;
    for (const RigObject& point : source.objects("points")) {
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

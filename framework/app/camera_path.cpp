// SPDX-License-Identifier: Apache-2.0
#include "framework/app/camera_path.hpp"

#include "framework/app/cli.hpp"
#include "framework/core/json_object.hpp"

#include <algorithm>

namespace ockham {
namespace {

Camera between(const Camera& a, const Camera& b, float t, UpAxis up) {
    if (t == 0.0f || t == 1.0f) return t == 0.0f ? a : b; // the keys to the bit

    const glm::vec3 position = glm::mix(a.position, b.position, t);
    const glm::vec3 forward = glm::mix(a.forward, b.forward, t);
    return look_at(position, position + forward, glm::mix(a.fov_y_degrees, b.fov_y_degrees, t), up);
}

} // namespace

std::vector<Camera> load_camera_path(const std::filesystem::path& path, int count, UpAxis up) {
    const nlohmann::json json = parse_json(path, "camera path");
    const JsonObject root(json, "camera path", path.string());
    root.warn_unknown({"keys"});
    std::vector<Camera> keys;
    for (const JsonObject& key : root.objects("keys")) {
        key.warn_unknown({"camera"});
        const std::optional<Camera> camera = parse_camera(key.text("camera"), up);
        if (!camera) key.refuse("camera", "\"px,py,pz tx,ty,tz fov\"");
        keys.push_back(*camera);
    }
    if (keys.empty()) root.refuse("keys", "an array of at least one camera");
    if (count <= 0) return keys;
    std::vector<Camera> cameras;
    for (int i = 0; i < count; ++i) {
        const float place = count > 1 ? static_cast<float>(i) / static_cast<float>(count - 1) *
                                            static_cast<float>(keys.size() - 1)
                                      : 0.0f;
        const std::size_t first =
            std::min(static_cast<std::size_t>(place), keys.size() - (keys.size() > 1 ? 2 : 1));
        const std::size_t next = std::min(first + 1, keys.size() - 1);
        cameras.push_back(between(keys[first], keys[next], place - static_cast<float>(first), up));
    }
    return cameras;
}

} // namespace ockham

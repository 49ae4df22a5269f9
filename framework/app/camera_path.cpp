// SPDX-License-Identifier: Apache-2.0
#include "framework/app/camera_path.hpp"

#include "framework/app/headless.hpp"
#include "framework/core/error.hpp"
#include "framework/core/json_object.hpp"

#include <algorithm>
#include <numbers>

namespace ockham {
namespace {

Camera between(const Camera& a, const Camera& b, float t, UpAxis up) {
    if (t == 0.0f || t == 1.0f) return t == 0.0f ? a : b; // the keys to the bit

    glm::vec3 forward = glm::mix(a.forward, b.forward, t);
    if (!(glm::length(forward) > 1e-6f)) forward = a.forward; // half-way between opposite ones
    // About the origin: far from it, a step of length 1 may be lost.
    Camera camera =
        look_at(glm::vec3(0.0f), forward, glm::mix(a.fov_y_degrees, b.fov_y_degrees, t), up);
    camera.position = glm::mix(a.position, b.position, t);
    return camera;
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

void add_camera_moves(Params& params, CameraMoves& moves, const char* centre) {
    const char* kPicture = "Picture";
    params
        .add("turntable", &moves.turntable,
            fmt::format("pictures around {}, -o numbered as out%03d.png; 0: one picture", centre))
        .range(0, 100000)
        .group(kPicture);
    params
        .add("camera-path", &moves.path,
            "JSON file of key cameras, -o numbered as out%03d.png; --frames pictures along it")
        .group(kPicture);
}

std::vector<Camera> choose_cameras(const CameraMoves& moves, const CommonOptions& options,
    const Camera& first, glm::vec3 centre, UpAxis up, int count) {
    if (!moves.path.empty() && (moves.turntable > 0 || !options.camera.empty()))
        fail_input("--camera-path: '{}' says where to stand; leave out --camera and --turntable",
            moves.path);
    std::vector<Camera> cameras{first};
    if (!moves.path.empty()) cameras = load_camera_path(moves.path, count, up);
    for (int i = 1; i < moves.turntable; ++i) {
        const float turn = static_cast<float>(i) / static_cast<float>(moves.turntable);
        cameras.push_back(turned(first, centre, up, 2.0f * std::numbers::pi_v<float> * turn));
    }
    for (Camera& camera : cameras)
        if (options.orthographic > 0) camera.orthographic_height = options.orthographic;
    return cameras;
}

void check_numbered(const CommonOptions& options, std::size_t pictures) {
    if (pictures > 1 && !options.output.empty() && !is_numbered(options.output)) {
        fail_input("--output: '{}' is one name for {} pictures; put a number in it, as out%03d.png",
            options.output, pictures);
    }
}

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
#include "framework/app/scene_source.hpp"

#include "framework/core/error.hpp"
#include "framework/core/log.hpp"
#include "framework/io/gltf.hpp"
#include "framework/io/rig.hpp"
#include "framework/scene/builtin.hpp"

#include <algorithm>
#include <cctype>
#include <filesystem>

namespace ockham {
namespace {

constexpr std::string_view kBuiltin = "builtin:";

Scene load_scene(const std::string& source, const CommonOptions& common) {
    if (source.starts_with(kBuiltin)) return builtin_scene(source.substr(kBuiltin.size()));
    return load_gltf(source, {.strict = common.strict, .allow_external = common.allow_external});
}

} // namespace

void add_scene_options(Params& params, SceneOptions& o) {
    const char* kScene = "Scene";
    std::string names;
    for (const BuiltinName& builtin : builtin_scenes()) {
        names += fmt::format("{}{}", names.empty() ? "" : "|", builtin.name);
    }
    params
        .add("scene", &o.scenes,
            fmt::format(
                ".gltf or .glb files, or builtin:{}; all in one world; default builtin:atrium",
                names))
        .positional()
        .group(kScene);
    add_scene_flags(params, o);
    params.add("environment", &o.environment, "\"r,g,b\" radiance of the background").group(kScene);
}

void add_scene_flags(Params& params, SceneOptions& o) {
    const char* kScene = "Scene";
    params
        .add("rig", &o.rig,
            "JSON with camera, background, ambient and lights in place of the scene's")
        .group(kScene);
    params.add("roughness", &o.roughness, "roughness of every material; -1: its own")
        .range(-1, 1)
        .group(kScene);
    params.add("lights", &o.lights, "use only the first so many lights; -1: all")
        .range(-1, 1 << 20)
        .group(kScene);
}

bool names_scene(const std::string& argument) {
    if (argument.starts_with(kBuiltin)) {
        const std::string name = argument.substr(kBuiltin.size());
        return std::ranges::any_of(
            builtin_scenes(), [&](const BuiltinName& builtin) { return builtin.name == name; });
    }
    std::string end = std::filesystem::path(argument).extension().string();
    std::ranges::transform(
        end, end.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return end == ".gltf" || end == ".glb";
}

Scene load_scenes(const SceneOptions& o, const CommonOptions& common) {
    Scene scene;
    bool first = true;
    for (const std::string& source :
        o.scenes.empty() ? std::vector<std::string>{"builtin:atrium"} : o.scenes) {
        Scene loaded = load_scene(source, common);
        if (first)
            scene = std::move(loaded);
        else
            append(scene, std::move(loaded));
        first = false;
    }
    if (!o.rig.empty()) apply(load_rig(o.rig), scene);
    if (!o.environment.empty()) scene.background = parse_color("environment", o.environment);
    if (o.lights >= 0 && static_cast<std::size_t>(o.lights) < scene.lights.size()) {
        scene.lights.resize(static_cast<std::size_t>(o.lights));
    }
    if (o.roughness >= 0.0f) {
        for (Material& material : scene.materials) {
            material.roughness = o.roughness;
            // An image would multiply the override away; its metalness goes on through the factor.
            material.metallic_roughness_texture.image = -1;
        }
    }
    const bool needs_light = std::any_of(scene.materials.begin(), scene.materials.end(),
        [](const Material& material) { return !material.unlit; });
    if (needs_light && scene.lights.empty() && scene.ambient == glm::vec3(0.0f) &&
        scene.triangles() > 0) {
        // Nothing shines: light it from the camera's side rather than show a black picture.
        log::warning("the scene has no lights: lit by a sun of its own and a grey sky");
        scene.lights.push_back({.name = "default sun",
            .type = LightType::directional,
            .direction = glm::normalize(glm::vec3(-0.4f, -1.0f, -0.6f)),
            .intensity = glm::vec3(3.0f),
            .casts_shadow = true});
        scene.ambient = glm::vec3(0.3f);
        if (scene.background == glm::vec3(0.0f)) scene.background = glm::vec3(0.3f);
    }
    return scene;
}

} // namespace ockham

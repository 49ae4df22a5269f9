// SPDX-License-Identifier: Apache-2.0
#include "samples/surface_volume/world.hpp"

#include "framework/core/error.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace ockham {
namespace {

/// Puts each of the inputs where it belongs.
void sort_inputs(const WorldOptions& o, SceneOptions& scene, VolumeOptions& volume) {
    const std::vector<std::string> both{"builtin:atrium", "builtin:cloud"};
    for (const std::string& input : o.inputs.empty() ? both : o.inputs)
        (names_scene(input) ? scene.scenes : volume.volume).push_back(input);
    if (volume.volume.size() > 1) {
        fail_input("found {} volumes ('{}', '{}' ...), expected one; scenes end in .gltf or .glb",
            volume.volume.size(), volume.volume[0], volume.volume[1]);
    }
    if (!o.place.empty() && (scene.scenes.empty() || volume.volume.empty()))
        fail_input("--place: a volume is placed among scenes; found no {}",
            scene.scenes.empty() ? "scene" : "volume");
}

/// The sun of --light shines on meshes as well: in place of the first directional light.
void set_sun(Scene& scene, const VolumeView& view) {
    const Light sun{.name = "--light",
        .type = LightType::directional,
        .direction = glm::normalize(view.light_direction),
        .intensity = view.light_irradiance,
        .casts_shadow = true};
    const auto first = std::ranges::find(scene.lights, LightType::directional, &Light::type);
    if (first != scene.lights.end())
        *first = sun;
    else
        scene.lights.insert(scene.lights.begin(), sun);
}

/// What reaches the medium from all around: by default, the scene's ambient light.
std::string environment_of(const WorldOptions& o, const Scene& scene) {
    if (!o.environment.empty()) return o.environment;
    return fmt::format("{},{},{}", scene.ambient.x, scene.ambient.y, scene.ambient.z);
}

} // namespace

void add_world_options(
    Params& params, WorldOptions& world, SceneOptions& scene, VolumeOptions& volume) {
    params
        .add("input", &world.inputs,
            "scenes and at most one volume, in any order; none: builtin:atrium builtin:cloud")
        .positional()
        .group("Scene");
    params
        .add("environment", &world.environment,
            "\"r,g,b\": radiance of the background and, in the medium, from all around; default: "
            "the scene's background and ambient light")
        .group("Scene");
    add_scene_flags(params, scene);
    params
        .add("place", &world.place,
            "\"tx,ty,tz rx,ry,rz scale\": where the volume's centre is in the scene, degrees about "
            "x, then y, then z, and its longest side; upright before")
        .group("Volume");
    add_volume_flags(params, volume);
}

World load_world(
    const WorldOptions& o, SceneOptions scene, VolumeOptions volume, const CommonOptions& common) {
    sort_inputs(o, scene, volume);
    World world{.scene = {}, .volume = {}, .placement = parse_place(o.place)};
    scene.environment = volume.environment = o.environment;
    if (!scene.scenes.empty()) world.scene = load_scenes(scene, common);
    if (volume.volume.empty()) return world;
    if (world.scene) volume.environment = environment_of(o, *world.scene);
    world.volume = load_volume_source(volume);
    if (!world.scene) return world;
    VolumeView& view = world.volume->view;
    if (!volume.light.empty()) set_sun(*world.scene, view);
    view = lit_by(*world.scene, view, view.environment);
    return world;
}

VolumePlacement parse_place(const std::string& text) {
    if (text.empty()) return {};
    std::istringstream words(text);
    std::string translation, rotation, scale, more;
    words >> translation >> rotation >> scale >> more;
    const std::vector<float> t = parse_numbers(translation), r = parse_numbers(rotation),
                             s = parse_numbers(scale);
    const auto finite = [](const std::vector<float>& v) {
        return std::ranges::all_of(v, [](float x) { return std::isfinite(x); });
    };
    if (t.size() != 3 || r.size() != 3 || s.size() != 1 || !more.empty() || !finite(t) ||
        !finite(r) || !finite(s) || !(s[0] > 0)) {
        fail_input(
            "--place: found '{}', expected \"tx,ty,tz rx,ry,rz scale\", the scale above 0", text);
    }
    return {{t[0], t[1], t[2]}, {r[0], r[1], r[2]}, s[0]};
}

void update_view(
    const WorldOptions& o, const VolumeOptions& volume, const Scene& scene, VolumeSource& source) {
    VolumeOptions in_world = volume;
    in_world.environment = environment_of(o, scene);
    update_view(in_world, source);
    source.view = lit_by(scene, source.view, source.view.environment);
}

} // namespace ockham

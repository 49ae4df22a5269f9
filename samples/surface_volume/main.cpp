// SPDX-License-Identifier: Apache-2.0
// surface_volume: renders meshes with a volume among them, in one graph, step after step, and
// reports what it took. README.md beside this file has examples.
#include "framework/app/camera_path.hpp"
#include "framework/app/cli.hpp"
#include "framework/app/headless.hpp"
#include "framework/app/scene_source.hpp"
#include "framework/app/volume_source.hpp"
#include "framework/core/error.hpp"
#include "framework/core/log.hpp"
#include "passes/pipelines/aa_options.hpp"
#include "passes/pipelines/surface_volume.hpp"
#include "passes/pipelines/volume_gi_options.hpp"
#include "passes/volume/frame.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <sstream>

using namespace ockham;

namespace {

struct Options {
    CommonOptions common;
    std::vector<std::string> inputs;
    std::string environment;
    std::string place;
    SceneOptions scene;
    VolumeOptions volume;
    AaOptions surfaces;
    VolumeGiOptions medium;
    CameraMoves moves;
    int steps = 32;
    int frames = 0;
};

void declare(Params& params, Options& o) {
    params
        .add("input", &o.inputs,
            "scenes and at most one volume, in any order; none: builtin:atrium builtin:cloud")
        .positional()
        .group("Scene");
    params
        .add("environment", &o.environment,
            "\"r,g,b\": radiance of the background and, in the medium, from all around; default: "
            "the scene's background and ambient light")
        .group("Scene");
    add_scene_flags(params, o.scene);
    params
        .add("place", &o.place,
            "\"tx,ty,tz rx,ry,rz scale\": where the volume's centre is in the scene, degrees about "
            "x, then y, then z, and its longest side; upright before")
        .group("Volume");
    add_volume_flags(params, o.volume);
    add_aa_options(params, o.surfaces);
    add_volume_gi_options(params, o.medium);
    params.add("steps", &o.steps, "samples of the medium per pixel").range(1, 1 << 24).group("Run");
    add_view_flags(params, o.common);
    add_camera_moves(params, o.moves, "the scene, or the volume without one");
    params
        .add(
            "frames", &o.frames, "pictures along --camera-path or --turntable; 0: one for each key")
        .range(0, 100000)
        .group("Picture");
    add_output_flags(params, o.common);
    add_run_flags(params, o.common);
}

/// Puts each of the inputs where it belongs.
void sort_inputs(Options& o) {
    if (o.inputs.empty()) o.inputs = {"builtin:atrium", "builtin:cloud"};
    for (const std::string& input : o.inputs)
        (names_scene(input) ? o.scene.scenes : o.volume.volume).push_back(input);
    if (o.volume.volume.size() > 1) {
        fail_input("found {} volumes ('{}', '{}' ...), expected one; scenes end in .gltf or .glb",
            o.volume.volume.size(), o.volume.volume[0], o.volume.volume[1]);
    }
    if (!o.place.empty() && (o.scene.scenes.empty() || o.volume.volume.empty()))
        fail_input("--place: a volume is placed among scenes; found no {}",
            o.scene.scenes.empty() ? "scene" : "volume");
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

/// What is rendered.
struct World {
    std::optional<Scene> scene;
    std::optional<VolumeSource> volume;
    VolumePlacement placement;
};

World load_world(Options& o) {
    sort_inputs(o);
    World world{.scene = {}, .volume = {}, .placement = parse_place(o.place)};
    if (!o.scene.scenes.empty()) {
        o.scene.environment = o.environment;
        world.scene = load_scenes(o.scene, o.common);
    }
    if (o.volume.volume.empty()) return world;
    o.volume.environment = o.environment;
    if (world.scene && o.environment.empty()) {
        const glm::vec3 ambient = world.scene->ambient;
        o.volume.environment = fmt::format("{},{},{}", ambient.x, ambient.y, ambient.z);
    }
    world.volume = load_volume_source(o.volume);
    apply(o.medium, world.volume->view);
    if (world.scene) {
        VolumeView& view = world.volume->view;
        if (!o.volume.light.empty()) set_sun(*world.scene, view);
        view = lit_by(*world.scene, view, view.environment);
    }
    return world;
}

std::vector<Camera> cameras_of(const Options& o, const World& world) {
    const Bounds bounds = world.scene ? world.scene->bounds() : Bounds{};
    const UpAxis up = world.scene ? UpAxis::y : UpAxis::z;
    Camera first = volume_camera();
    if (world.scene) {
        first = choose_camera(o.common, *world.scene, bounds);
    } else if (!o.common.camera.empty()) {
        const std::optional<Camera> given = parse_camera(o.common.camera, up);
        if (!given)
            fail_input("--camera: found '{}', expected \"px,py,pz tx,ty,tz fov\"", o.common.camera);
        first = *given;
    }
    const glm::vec3 centre = bounds.empty() ? glm::vec3(0.0f) : bounds.center();
    return choose_cameras(o.moves, o.common, first, centre, up, o.frames);
}

SurfaceVolumeParams picture_params(
    const Options& o, const World& world, std::size_t pictures, gpu::Device& device) {
    SurfaceVolumeParams p;
    p.surfaces = aa_params(o.surfaces);
    p.surfaces.history = p.surfaces.history && pictures > 1;
    p.surfaces.export_counts = true;
    VolumeMode mode = volume_mode(o.medium).value_or(VolumeMode::path);
    if (world.volume && !volume_mode(o.medium)) {
        const ModeChoice choice = choose_mode(world.volume->volume, pictures,
            static_cast<std::uint32_t>(o.medium.cache_scale), device.allocator().budget_bytes());
        log::info("--mode auto: {}, for {}", name_of(choice.mode), choice.why);
        mode = choice.mode;
    }
    p.medium = volume_gi_params(o.medium, mode);
    p.medium.width = static_cast<std::uint32_t>(o.common.width);
    p.medium.height = static_cast<std::uint32_t>(o.common.height);
    for (const auto& [name, file] : parse_captures(o.common)) p.medium.captures.push_back(name);
    return p;
}

/// All steps of one picture, to their end. False where it was interrupted.
bool render_picture(SurfaceVolume& picture, int steps, Progress& progress, std::size_t done,
    HeadlessRun& run, gpu::Device& device) {
    const int last = picture.medium() ? steps : 1; // meshes alone are done at once
    for (int step = 0; step < last; ++step) {
        if (interrupted()) return false;
        reload_shaders(device);
        picture.execute();
        if (done > 0 || step > 0 || last == 1) run.add_times(picture.times()); // the first compiles
        progress.update(done + static_cast<std::size_t>(step) + 1);
    }
    while (!picture.finished()) {
        if (interrupted()) return false;
        picture.drain();
    }
    return true;
}

void print_summary(const FrameTimes& times, SurfaceVolume& picture, std::size_t steps,
    const std::optional<ImageError>& error) {
    fmt::print("gpu     {:9.2f} ms per step (median of {}), {} steps\n", times.total(),
        times.frames(), steps);
    if (const std::optional<double> percent = picture.sample_percent())
        fmt::print("samples {:9.2f} % of those of meshes\n", *percent);
    if (picture.medium()) {
        const VolumeStatistics s = picture.medium()->statistics();
        fmt::print("paths   {:9.3g}, {:.3g} lookups of the field\n", static_cast<double>(s.paths),
            static_cast<double>(s.steps));
        if (s.relative_error)
            fmt::print("noise   {:9.2g} of the mean\n", *s.relative_error);
    }
    if (error) print_error(*error);
}

nlohmann::ordered_json statistics_of(SurfaceVolume& picture) {
    nlohmann::ordered_json more;
    if (const std::optional<double> percent = picture.sample_percent())
        more["samples"] = {{"percent", *percent}};
    if (picture.medium()) {
        const VolumeStatistics s = picture.medium()->statistics();
        more["volume"] = {{"paths", s.paths}, {"steps", s.steps}, {"resumed", s.resumed},
            {"truncated", s.truncated}, {"cells", s.cells}, {"cell_bytes", s.cell_bytes},
            {"majorant_cells", s.majorant_cells}, {"mean_variance", nullptr}};
        if (s.mean_variance) more["volume"]["mean_variance"] = *s.mean_variance;
    }
    return more;
}

int render(int argc, char** argv) {
    Options o;
    Params params;
    declare(params, o);
    if (const std::optional<int> done = parse_command_line(
            argc, argv, "Renders meshes with a volume among them.", params, o.common)) {
        return *done;
    }
    HeadlessRun run(o.common, argc, argv);
    World world = load_world(o);
    const std::vector<Camera> cameras = cameras_of(o, world);
    check_numbered(o.common, cameras.size());
    if (cameras.size() > 1 && !o.common.reference.empty())
        fail_input("--reference: {} pictures cannot be measured against one", cameras.size());

    gpu::Device device(device_options(o.common));
    watch_shaders(device, o.common);
    log::info("{} ({})", device.info().name, device.info().driver_version);
    const SurfaceVolumeParams p = picture_params(o, world, cameras.size(), device);
    std::optional<LitScene> lit;
    if (world.scene) lit.emplace(device, std::move(*world.scene));
    std::optional<MediumSource> medium;
    if (world.volume) {
        const VolumeSource& v = *world.volume;
        medium.emplace(v.volume, v.transfer, v.environment, v.view, world.placement);
    }
    SurfaceVolume picture(device, lit ? &*lit : nullptr, medium, cameras.front(), p);
    run.announce(device, picture.executor());
    log::info("graph {} MiB", picture.executor().plan().bytes_peak >> 20);

    const std::size_t steps = picture.medium() ? static_cast<std::size_t>(o.steps) : 1;
    Progress progress("step", steps * cameras.size(), o.common.quiet);
    for (std::size_t i = 0; i < cameras.size(); ++i) {
        if (i > 0) picture.set_camera(cameras[i]);
        if (!render_picture(picture, o.steps, progress, i * steps, run, device)) return 130;
        run.save_picture(picture.picture(), static_cast<int>(i));
    }
    expect_no_validation_messages(device);
    run.save_captures(picture.executor(), picture.captures());
    const std::optional<ImageError> error = run.error_of(picture.picture());
    print_summary(run.times(), picture, steps * cameras.size(), error);
    run.report(device, picture.executor(), statistics_of(picture), error);
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    return run_program([&] { return render(argc, argv); });
}

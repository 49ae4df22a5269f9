// SPDX-License-Identifier: Apache-2.0
// surface_volume: renders meshes with a volume among them, in one graph, step after step, and
// reports what it took. README.md beside this file has examples.
#include "framework/app/camera_path.hpp"
#include "framework/app/cli.hpp"
#include "framework/app/headless.hpp"
#include "framework/core/error.hpp"
#include "framework/core/log.hpp"
#include "passes/pipelines/aa_options.hpp"
#include "passes/pipelines/volume_gi_options.hpp"
#include "passes/volume/frame.hpp"
#include "samples/surface_volume/world.hpp"

#include <nlohmann/json.hpp>

using namespace ockham;

namespace {

struct Options {
    CommonOptions common;
    WorldOptions world;
    SceneOptions scene;
    VolumeOptions volume;
    AaOptions surfaces;
    VolumeGiOptions medium;
    CameraMoves moves;
    int steps = 32;
    int frames = 0;
};

void declare(Params& params, Options& o) {
    add_world_options(params, o.world, o.scene, o.volume);
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
    for (int step = 0; step < steps; ++step) {
        if (interrupted()) return false;
        reload_shaders(device);
        picture.execute();
        if (done > 0 || step > 0 || steps == 1)
            run.add_times(picture.times()); // the first compiles
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
        fmt::print("samples {:9.2f} % of those of surfaces\n", *percent);
    if (picture.medium()) {
        const VolumeStatistics s = picture.medium()->statistics();
        fmt::print("paths   {:9.3g}, {:.3g} lookups of the field\n", static_cast<double>(s.paths),
            static_cast<double>(s.steps));
        if (s.relative_error) fmt::print("noise   {:9.2g} of the mean\n", *s.relative_error);
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
    World world = load_world(o.world, o.scene, o.volume, o.common);
    if (world.volume) apply(o.medium, world.volume->view);
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

    const int steps = picture.all_at_once() ? 1 : o.steps;
    const std::size_t all_steps = static_cast<std::size_t>(steps) * cameras.size();
    Progress progress("step", all_steps, o.common.quiet);
    for (std::size_t i = 0; i < cameras.size(); ++i) {
        if (i > 0) picture.set_camera(cameras[i]);
        if (!render_picture(
                picture, steps, progress, i * static_cast<std::size_t>(steps), run, device))
            return 130;
        run.save_picture(picture.picture(), static_cast<int>(i));
    }
    expect_no_validation_messages(device);
    run.save_captures(picture.executor(), picture.captures());
    const std::optional<ImageError> error = run.error_of(picture.picture());
    print_summary(run.times(), picture, all_steps, error);
    run.report(device, picture.executor(), statistics_of(picture), error);
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    return run_program([&] { return render(argc, argv); });
}

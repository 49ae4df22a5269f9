// SPDX-License-Identifier: Apache-2.0
#include "samples/chart/volume_runs.hpp"

#include "framework/core/error.hpp"
#include "framework/core/timer.hpp"
#include "framework/image_error/image_error.hpp"
#include "framework/io/image_file.hpp"
#include "framework/scene/builtin_volume.hpp"
#include "passes/volume/frame.hpp"
#include "samples/chart/volume_choice.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <bit>
#include <cmath>

namespace ockham::chart {
namespace {

constexpr const char* kSkyFile = "sky.exr";
/// Of a half: after that the errors are small enough to be told, and the suites have an end.
constexpr double kReferenceSeconds = 60;
constexpr std::uint64_t kMostTogether = 16; ///< steps of an execution, as in volume_gi
constexpr std::uint32_t kReferenceSeed = 1u << 20; ///< far from those of runs

/// What is known to look well of the volumes that people have; others get the defaults.
struct Look {
    const char* stem;
    const char* transfer;
    const char* iso;
    const char* camera;
};
constexpr Look kLooks[] = {
    {"cranium_ct", "ct-soft", "300", "-0.55,1.8,0.1 0,0.05,-0.02 28"},
    {"engine", "", "110.5", "-1.1,-1.5,1.1 0,0,-0.02 30"},
    {"brainweb_t1", "mri", "", "1.7,0.7,0.45 -0.1,0,-0.04 29"},
    {"mni152_2009", "mri", "", ""},
    {"smoke_density", "smoke", "", ""},
    {"bi2o3_c0", "smoke", "0.1", "0.9,-2.2,0.8 0,0,0 32"},
};

VolumeScene given_scene(const std::string& volume) {
    VolumeScene scene;
    scene.name = volume.starts_with("builtin:") ? volume.substr(8)
                                                : std::filesystem::path(volume).stem().string();
    scene.options.volume = {volume};
    for (const Look& look : kLooks) {
        if (scene.name != look.stem) continue;
        scene.options.transfer = look.transfer;
        scene.options.iso = look.iso;
        scene.camera = look.camera;
    }
    scene.options.density_scale = 60;
    scene.options.albedo = 0.9f;
    scene.options.light = "0.3,0.9,-0.5 3,2.8,2.5";
    scene.options.environment = "0.1,0.13,0.18";
    return scene;
}

/// Means of R, G, B of two pictures of one size.
Image mean_of(const Image& a, const Image& b) {
    Image mean(a.width(), a.height(), {"R", "G", "B"});
    for (const char* name : {"R", "G", "B"})
        for (std::size_t i = 0; i < mean.pixels(); ++i)
            mean.plane(name)[i] = 0.5f * (a.plane(name)[i] + b.plane(name)[i]);
    return mean;
}

VolumeReference reference_of(const Image& a, const Image& b, double samples) {
    VolumeReference reference{mean_of(a, b), samples};
    // Halves differ by twice the variance of one, which is twice that of their mean.
    const ImageError halves = image_error(a, b);
    reference.mse = halves.mse / 4;
    reference.relmse = halves.relmse / 4;
    return reference;
}

double seconds_of(const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
}

} // namespace

VolumeSource VolumeScene::load() const {
    VolumeSource source = load_volume_source(options);
    if (sky) source.environment = sky_with_sun();
    return source;
}

Camera VolumeScene::view() const {
    if (camera.empty()) return volume_camera();
    const std::optional<Camera> given = parse_camera(camera, UpAxis::z);
    if (!given) fail_input("--camera: found '{}', expected \"px,py,pz tx,ty,tz fov\"", camera);
    return *given;
}

std::string VolumeScene::flags() const {
    std::string text = options.volume.front();
    const auto add = [&](const char* flag, const std::string& value) {
        if (value.empty()) return;
        const bool quote = value.find(' ') != std::string::npos;
        text += fmt::format(" --{} {}{}{}", flag, quote ? "\"" : "", value, quote ? "\"" : "");
    };
    add("transfer", options.transfer);
    add("window", options.window);
    add("iso", options.iso);
    if (!options.iso.empty()) add("shading", options.shading);
    add("density-scale", fmt::format("{}", options.density_scale));
    add("albedo", fmt::format("{}", options.albedo));
    add("light", options.light);
    add("environment", sky ? kSkyFile : options.environment);
    add("crop", options.crop);
    add("camera", camera);
    return text;
}

std::string VolumeScene::inputs() const {
    return flags() + " " + fingerprint_of(options.volume.front());
}

VolumeScene VolumeScene::with_shading(const std::string& shading) const {
    VolumeScene scene = *this;
    scene.options.shading = shading;
    return scene;
}

std::vector<VolumeScene> volume_scenes(const ChartOptions& options) {
    std::vector<VolumeScene> scenes;
    for (const std::string& volume : options.volumes) scenes.push_back(given_scene(volume));
    if (!scenes.empty()) return scenes;
    const char* side = options.quick ? ":48" : "";
    scenes.push_back(given_scene(fmt::format("builtin:cloud{}", side)));
    scenes.back().name = "cloud";
    scenes.push_back(given_scene(fmt::format("builtin:fingers{}", side)));
    scenes.back().name = "fingers";
    scenes.back().options.transfer = "smoke";
    scenes.back().options.iso = "200";
    scenes.back().options.density_scale = 20; // haze everywhere: long paths
    return scenes;
}

std::vector<VolumeScene> class_scenes(const ChartOptions& options) {
    std::vector<VolumeScene> scenes = volume_scenes(options);
    if (!options.volumes.empty()) return scenes;
    const auto add = [&](const char* name, const char* volume, float density) -> VolumeScene& {
        scenes.push_back(
            given_scene(fmt::format("builtin:{}{}", volume, options.quick ? ":48" : "")));
        scenes.back().name = name;
        scenes.back().options.density_scale = density;
        return scenes.back();
    };
    add("thin cloud", "cloud", 6);
    VolumeScene& milk = add("milk", "constant", 20);
    milk.options.albedo = 1;
    milk.options.window = "0.5,1"; // opacity = value
    VolumeScene& cluster = add("cluster", "cluster", 40);
    cluster.options.transfer = "smoke";
    cluster.options.iso = "120";
    VolumeScene& shells = add("shells", "shells", 4);
    shells.options.transfer = "smoke";
    shells.options.iso = "100";
    return scenes;
}

double cpu_seconds() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return seconds_of(usage.ru_utime) + seconds_of(usage.ru_stime);
}

double gpu_seconds(const Executor& executor) {
    double sum = 0;
    for (const PassTime& time : executor.times()) sum += 1e-3 * time.milliseconds;
    return sum;
}

const VolumeReference& VolumeReferences::of(const VolumeScene& scene, VolumeMode mode) {
    // Without surfaces both modes have one expectation.
    if (scene.options.iso.empty()) mode = VolumeMode::path;
    const std::string what = fmt::format("{} {} {} {} {}", scene.inputs(), name_of(mode), side_,
        context_.options.quick, context_.device_text());
    if (const auto found = kept_.find(what); found != kept_.end()) return found->second;

    const std::filesystem::path folder = context_.options.out / "references";
    std::filesystem::create_directories(folder);
    if (scene.sky) save_image(context_.options.out / kSkyFile, sky_with_sun());
    const int steps = context_.options.quick ? 8 : 256;
    constexpr std::uint32_t kPerStep = 32;
    Image halves[2];
    double samples = 0;
    for (std::uint32_t half = 0; half < 2; ++half) {
        const std::filesystem::path file =
            folder / fmt::format("{}_{}.exr", fingerprint(what), half);
        if (std::filesystem::exists(file)) {
            halves[half] = load_image(file);
            const std::string& taken = halves[half].metadata["samples"];
            samples += taken.empty() ? double(steps) * kPerStep : std::stod(taken);
            continue;
        }
        VolumeGiParams params;
        params.width = params.height = side_;
        params.mode = mode;
        params.samples_per_step = kPerStep;
        params.sobol = false; // halves are to be independent, and their error is to be known
        VolumeSource source = scene.load();
        source.view.seed = kReferenceSeed + half;
        VolumeGi gi(context_.device(), source.volume, source.transfer, source.environment,
            source.view, scene.view(), params);
        gi.execute(); // there is a picture, interrupted or not
        int step = 1;
        for (const Timer timer;
             step < steps && timer.seconds() < kReferenceSeconds && !interrupted(); ++step)
            gi.execute();
        gi.finish();
        halves[half] = gi.picture();
        const int taken = step * static_cast<int>(kPerStep);
        samples += taken;
        halves[half].metadata["samples"] = fmt::format("{}", taken);
        halves[half].metadata["command"] = fmt::format(
            "volume_gi {} --mode {} --sampler independent --steps {} --seed {} --width {} "
            "--height {}",
            scene.flags(), name_of(mode), taken, kReferenceSeed + half, side_, side_);
        if (!interrupted()) save_image(file, halves[half]);
    }
    return kept_[what] = reference_of(halves[0], halves[1], samples);
}

VolumeRun::VolumeRun(gpu::Device& device, const VolumeScene& scene, const VolumeGiParams& params,
    const VolumeReference& reference, double seconds, const VolumeReference* truth)
    : source_(scene.load()), reference_(reference), truth_(truth), seconds_(seconds),
      seed_(source_.view.seed), gi_(device, source_.volume, source_.transfer, source_.environment,
                                    source_.view, scene.view(), params) {
    gi_.execute(); // compiles kernels, uploads
    gi_.finish();
}

std::vector<Row> VolumeRun::measure() {
    source_.view.seed = ++seed_;
    gi_.set_view(source_.view);
    std::vector<Row> rows;
    double gpu = 0, cpu = 0;
    const std::uint64_t least = truth_ != nullptr ? kProbeSteps : 1; // else it is no class
    for (std::uint64_t steps = 1; (gpu < seconds_ || steps <= least) && steps < 65536; steps *= 2) {
        const double start = cpu_seconds();
        while (gi_.steps() < steps) {
            if (interrupted()) return rows;
            const std::uint64_t missing = std::min(steps - gi_.steps(), kMostTogether);
            gi_.execute(gi_.steps_together() ? static_cast<std::uint32_t>(missing) : 1);
            gpu += gpu_seconds(gi_.executor());
        }
        while (!gi_.finished()) {
            gi_.drain();
            gpu += gpu_seconds(gi_.executor());
        }
        cpu += cpu_seconds() - start;
        const Image picture = gi_.picture();
        const ImageError error = image_error(picture, reference_.picture);
        const VolumeStatistics now = gi_.statistics();
        rows.push_back({.knob = static_cast<double>(steps),
            .values = {{"samples", static_cast<double>(steps)}, {"gpu_seconds", gpu},
                {"cpu_seconds", cpu}, {"psnr", error.psnr}, {"rmse", std::sqrt(error.mse)},
                {"flip", error.flip.mean}, {"ssim", error.ssim}, {"relmse", error.relmse},
                {"paths", static_cast<double>(now.paths)},
                {"cells", static_cast<double>(now.cells)},
                {"cell_bytes", static_cast<double>(now.cell_bytes)},
                {"converged", now.cache_converged ? 1.0 : 0.0}}});
        if (truth_ != nullptr)
            rows.back().values["true_psnr"] =
                truth_ == &reference_ ? error.psnr : image_error(picture, truth_->picture).psnr;
    }
    return rows;
}

std::map<std::string, Picture> VolumeRun::pictures() {
    const Image picture = gi_.picture();
    return {
        {"picture", to_picture(picture)}, {"error", error_picture(picture, reference_.picture)}};
}

double converge(VolumeGi& gi, int most, double seconds) {
    double gpu = 0;
    int executions = 0;
    do {
        gi.execute();
        gpu += gpu_seconds(gi.executor());
    } while (++executions < most && gpu < seconds && !interrupted() &&
             !gi.statistics().cache_converged);
    return gpu;
}

std::vector<Job> JobList::jobs() const {
    std::vector<Job> jobs;
    for (const Entry& entry : entries_) jobs.push_back(entry.job);
    return jobs;
}

std::unique_ptr<Subject> JobList::open(const Job& job) const {
    for (const Entry& entry : entries_)
        if (entry.job.key() == job.key()) return entry.open();
    fail_input("no measurement '{}' in this run", job.series);
}

} // namespace ockham::chart

// SPDX-License-Identifier: Apache-2.0
// What pictures of volumes cost and how exact they are: tracking rate, time for an equal error,
// means of a cube with known values, slopes of convergence. Repetitions of what is compared
// alternate, and figures are medians with their spread. docs/volume_performance.md explains them.
#include "framework/core/error.hpp"
#include "framework/core/log.hpp"
#include "framework/gpu/device.hpp"
#include "framework/image_error/image_error.hpp"
#include "framework/io/volume_file.hpp"
#include "framework/scene/builtin_volume.hpp"
#include "passes/pipelines/volume_gi.hpp"
#include "passes/volume/frame.hpp"

#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <numbers>
#include <span>

namespace ockham {
namespace {

/// Everything but the technique.
struct Scene {
    Volume volume;
    TransferFunction transfer = {};
    Image environment = {};
    VolumeView view = {};
    Camera camera = volume_camera();
};

gpu::Device& device() {
    static gpu::Device instance{gpu::DeviceOptions{}};
    return instance;
}

/// User and system time of all threads.
double cpu_seconds() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    const auto seconds = [](const timeval& t) {
        return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double gpu_seconds(const Executor& executor) {
    double sum = 0;
    for (const PassTime& time : executor.times()) sum += 1e-3 * time.milliseconds;
    return sum;
}

/// Median, and the quartiles as its spread.
struct Figure {
    explicit Figure(std::vector<double> values) : values_(std::move(values)) {
        std::sort(values_.begin(), values_.end());
    }
    double quantile(double q) const {
        const double place = q * static_cast<double>(values_.size() - 1);
        const auto below = static_cast<std::size_t>(place);
        const std::size_t above = std::min(below + 1, values_.size() - 1);
        return std::lerp(values_[below], values_[above], place - static_cast<double>(below));
    }
    void report(benchmark::State& state, const std::string& name) const {
        state.counters[name] = quantile(0.5);
        state.counters[name + "_q1"] = quantile(0.25);
        state.counters[name + "_q3"] = quantile(0.75);
    }

private:
    std::vector<double> values_;
};

double mean_of(std::span<const double> values) {
    double sum = 0;
    for (const double value : values) sum += value;
    return sum / static_cast<double>(values.size());
}

/// Of the mean of values that are independent of each other.
double standard_error(std::span<const double> values) {
    const double mean = mean_of(values);
    double sum = 0;
    for (const double value : values) sum += (value - mean) * (value - mean);
    const auto n = static_cast<double>(values.size());
    return std::sqrt(sum / (n * (n - 1)));
}

std::vector<double> luminances(const Image& image) {
    const auto r = image.plane("R"), g = image.plane("G"), b = image.plane("B");
    std::vector<double> out(image.pixels());
    for (std::size_t i = 0; i < out.size(); ++i)
        out[i] = 0.2126 * r[i] + 0.7152 * g[i] + 0.0722 * b[i];
    return out;
}

/// Of one pixel, mean over the picture, from two pictures with independent samples.
double variance_of(std::span<const double> a, std::span<const double> b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += 0.5 * (a[i] - b[i]) * (a[i] - b[i]);
    return sum / static_cast<double>(a.size());
}

// ---- scenes

/// The opacity rises from 0 at the lowest value to 1 at the highest.
TransferFunction ramp(double low, double high) {
    return {{{.value = low, .opacity = 0}, {.value = high, .opacity = 1}}};
}

/// In a cube of `side`^3 voxels, bytes, between 0 and 255.
Volume resampled(const Volume& from, std::uint32_t side) {
    const auto [low, high] = value_range(from);
    Volume volume;
    volume.name = from.name;
    volume.dims = glm::uvec3(side);
    volume.voxels.reserve(volume.voxel_count());
    for (std::uint32_t z = 0; z < side; ++z)
        for (std::uint32_t y = 0; y < side; ++y)
            for (std::uint32_t x = 0; x < side; ++x) {
                const double value = from.sample((glm::dvec3(x, y, z) + 0.5) / double(side));
                volume.voxels.push_back(
                    static_cast<std::byte>((value - low) / (high - low) * 255.0 + 0.5));
            }
    return volume;
}

/// A real volume where there is one, else a made one.
Volume data_volume(const std::string& name) {
#ifdef OCKHAM_DATA_DIR
    const std::string file = std::string(OCKHAM_DATA_DIR) + "/volumes/" + name + ".json";
    if (std::filesystem::exists(file)) return load_volume(file);
#endif
    log::warning("no volume '{}' (CMake's OCKHAM_DATA_DIR): builtin:cloud in its place", name);
    return builtin_volume("builtin:cloud");
}

Scene data_scene(const std::string& name) {
    Volume volume = data_volume(name);
    const bool ct = volume.name.find("cranium") != std::string::npos;
    TransferFunction transfer = ct ? preset_transfer("ct-bone", volume) : default_transfer(volume);
    return {.volume = std::move(volume), .transfer = std::move(transfer)};
}

/// A cube in a white world, whose middle covers the central half of the picture's sides.
Scene cube(std::uint32_t side, double albedo, double g) {
    Scene scene{.volume = builtin_volume("builtin:constant", side)};
    scene.transfer.points = {{.value = 1, .opacity = 1}};
    scene.view.density_scale = 4;
    scene.view.albedo = static_cast<float>(albedo);
    scene.view.phase_g = static_cast<float>(g);
    scene.camera = look_at({0, 0, 2}, {0, 0, 0}, static_cast<float>(180 / std::numbers::pi));
    return scene;
}

// ---- pictures

/// Square, of path mode with defaults.
VolumeGiParams picture_params(std::uint32_t side, std::uint32_t samples) {
    VolumeGiParams params;
    params.width = params.height = side;
    params.samples_per_step = samples;
    params.iterations = kPathIterations;
    return params;
}

/// One technique for one scene, kept over many pictures of different seeds.
class Renderer {
public:
    Renderer(const Scene& scene, const VolumeGiParams& params)
        : view_(scene.view), gi_(device(), scene.volume, scene.transfer, scene.environment,
                                 scene.view, scene.camera, params) {
        gi_.execute(); // compiles kernels, uploads
        gi_.finish();
    }

    struct Picture {
        std::vector<double> luminance;
        double cpu = 0, gpu = 0, steps = 0; // seconds
    };
    Picture picture(std::uint32_t seed, int executions = 1) {
        view_.seed = seed;
        gi_.set_view(view_);
        Picture out;
        const double start = cpu_seconds();
        for (int i = 0; i < executions; ++i) {
            gi_.execute();
            out.gpu += gpu_seconds(gi_.executor());
        }
        gi_.finish();
        out.cpu = cpu_seconds() - start;
        out.steps = static_cast<double>(gi_.statistics().steps);
        out.luminance = luminances(gi_.picture());
        return out;
    }
    VolumeGi& gi() { return gi_; }

private:
    VolumeView view_;
    VolumeGi gi_;
};

// ---- measurements

/// One majorant for all and no light sampled: each step is a tentative collision, one lookup.
void tracking_rate(benchmark::State& state) {
    Scene scene{.volume = resampled(data_volume("engine"), 128), .transfer = ramp(0, 255)};
    scene.view.density_scale = 40;
    scene.view.albedo = 0.9f;
    scene.camera.fov_y_degrees = 20; // no pixel looks past the box
    VolumeGiParams params = picture_params(64, 64);
    params.sobol = state.range(0) != 0;
    params.majorant_grid = params.nee = false;
    Renderer renderer(scene, params);
    std::vector<double> cpu, gpu;
    double steps = 0;
    for (auto _ : state)
        for (std::uint32_t seed = 2; seed < 9; ++seed) {
            const Renderer::Picture picture = renderer.picture(seed);
            steps = picture.steps;
            cpu.push_back(1e-6 * steps / picture.cpu);
            gpu.push_back(1e-6 * steps / picture.gpu);
        }
    Figure(cpu).report(state, "Msteps_per_cpu_second");
    state.counters["Msteps_per_gpu_second"] = Figure(gpu).quantile(0.5);
    state.counters["steps_per_path"] = steps / (64.0 * 64.0 * 64.0);
}

/// In a white world, under a sky with a sun of 10 degrees, or in the light of volume_gi's defaults.
Scene lit_scene(const std::string& name, const std::string& light, float density) {
    Scene scene = data_scene(name);
    scene.view.density_scale = density;
    scene.view.albedo = 0.9f;
    if (light == "sky") scene.environment = sky_with_sun();
    if (light == "default") {
        scene.view.light_direction = {0.5f, 0.7f, -0.6f};
        scene.view.light_irradiance = glm::vec3(2.0f);
        scene.view.environment = {0.12f, 0.17f, 0.26f};
    }
    return scene;
}

/// Time times variance, of `--majorant global --nee off` over that of the defaults; and of
/// `--majorant global --nee off --sampler independent`: the plainest there is.
void equal_error(
    benchmark::State& state, const std::string& name, const std::string& light, float density) {
    const Scene scene = lit_scene(name, light, density);
    VolumeGiParams params = picture_params(64, 16);
    Renderer fast(scene, params);
    params.majorant_grid = params.nee = false;
    Renderer plain(scene, params);
    params.sobol = false;
    Renderer plainest(scene, params);
    const double paths = 64.0 * 64.0 * 16.0;
    std::vector<double> ratio, cpu_ratio, variance_ratio, difference, independent_ratio;
    double steps_fast = 0, steps_plain = 0;
    std::vector<double> nanoseconds, nanoseconds_plain;
    for (auto _ : state)
        for (std::uint32_t seed = 2; seed < 16; seed += 2) {
            const Renderer::Picture a = plain.picture(seed), b = fast.picture(seed);
            const Renderer::Picture c = plain.picture(seed + 1), d = fast.picture(seed + 1);
            cpu_ratio.push_back((a.cpu + c.cpu) / (b.cpu + d.cpu));
            variance_ratio.push_back(
                variance_of(a.luminance, c.luminance) / variance_of(b.luminance, d.luminance));
            ratio.push_back(cpu_ratio.back() * variance_ratio.back());
            const Renderer::Picture e = plainest.picture(seed), f = plainest.picture(seed + 1);
            independent_ratio.push_back((e.cpu + f.cpu) / (b.cpu + d.cpu) *
                                        variance_of(e.luminance, f.luminance) /
                                        variance_of(b.luminance, d.luminance));
            difference.push_back(mean_of(a.luminance) - mean_of(b.luminance));
            difference.push_back(mean_of(c.luminance) - mean_of(d.luminance));
            steps_plain = a.steps, steps_fast = b.steps;
            nanoseconds.push_back(0.5e9 * (b.cpu + d.cpu) / paths);
            nanoseconds_plain.push_back(0.5e9 * (a.cpu + c.cpu) / paths);
        }
    Figure(ratio).report(state, "ratio");
    Figure(cpu_ratio).report(state, "cpu_ratio");
    Figure(variance_ratio).report(state, "variance_ratio");
    Figure(independent_ratio).report(state, "ratio_independent");
    state.counters["z"] = mean_of(difference) / standard_error(difference);
    state.counters["ns_per_path"] = Figure(nanoseconds).quantile(0.5);
    state.counters["ns_per_path_plain"] = Figure(nanoseconds_plain).quantile(0.5);
    state.counters["steps_per_path"] = steps_fast / paths;
    state.counters["steps_per_path_plain"] = steps_plain / paths;
}

/// CPU time of 32 steps one by one, over that of the same taken together as volume_gi does.
void steps_together(benchmark::State& state, const std::string& name, float density) {
    const Scene scene = lit_scene(name, "default", density);
    Renderer renderer(scene, picture_params(128, 1));
    VolumeGi& gi = renderer.gi();
    std::vector<double> ratio;
    for (auto _ : state)
        for (int repetition = 0; repetition < 7; ++repetition) {
            double cpu[2];
            for (const bool together : {false, true}) {
                gi.set_camera(scene.camera);
                const double start = cpu_seconds();
                for (std::uint32_t steps = 0; steps < 32;) {
                    const std::uint32_t more = together ? std::clamp(steps, 1u, 16u) : 1;
                    gi.execute(more);
                    steps += more;
                }
                gi.finish();
                cpu[together ? 1 : 0] = cpu_seconds() - start;
            }
            ratio.push_back(cpu[0] / cpu[1]);
        }
    Figure(ratio).report(state, "ratio");
}

/// Executes until the cache has reached its error; how often, at most `most` times.
int converge(VolumeGi& gi, int most) {
    int executions = 0;
    do gi.execute();
    while (++executions < most && !gi.statistics().cache_converged);
    return executions;
}

struct CubeCase {
    double albedo, g, value;
};
/// Independent analog tracking and Cycles agree on these within .0001 and .001.
constexpr CubeCase kCubes[] = {
    {1, 0, 1}, {.8, 0, .5610}, {.5, 0, .2737}, {.8, .6, .5414}, {0, 0, .056846}};

/// Mean of the central half and its standard error, over independent pictures. Of mode caching each
/// has a cache of its own, of side / 2 cells along a side.
struct Measured {
    double mean = 0, error = 0;
};

std::vector<double> central_half(const Image& picture) {
    const std::vector<double> pixels = luminances(picture);
    const int side = picture.width();
    std::vector<double> centre;
    for (int y = side / 4; y < side * 3 / 4; ++y)
        centre.insert(centre.end(), pixels.begin() + y * side + side / 4,
            pixels.begin() + y * side + side * 3 / 4);
    return centre;
}

Measured centre_of_cube(const CubeCase& c, VolumeMode mode, bool gather, std::uint32_t side) {
    const bool caching = mode == VolumeMode::caching;
    VolumeGiParams params = picture_params(64, 64);
    params.mode = mode;
    params.gather = gather;
    params.sobol = false;
    Scene scene = cube(side, c.albedo, c.g);
    std::vector<std::vector<double>> pictures;
    std::vector<double> means;
    for (std::uint32_t seed = 1; seed <= (caching ? 3u : 8u); ++seed) {
        scene.view.seed = seed;
        Renderer renderer(scene, params);
        VolumeGi& gi = renderer.gi();
        if (caching) {
            converge(gi, 64);
            gi.set_camera(scene.camera); // forgets pixels that saw an unfinished cache
        }
        for (int i = 0; i < 4; ++i) gi.execute();
        gi.finish();
        pictures.push_back(central_half(gi.picture()));
        means.push_back(mean_of(pictures.back()));
    }
    // Pixels are independent of each other, but for the noise that they share with the cache; that
    // shows in the spread of the means alone.
    double variance = 0;
    for (std::size_t i = 1; i < pictures.size(); ++i)
        variance += variance_of(pictures[i - 1], pictures[i]) / double(pictures.size() - 1);
    const double samples = double(pictures.size() * pictures[0].size());
    const double error = std::sqrt(variance / samples);
    return {mean_of(means), caching ? std::max(error, standard_error(means)) : error};
}

void cube_mean(
    benchmark::State& state, const CubeCase& c, VolumeMode mode, bool gather, std::uint32_t side) {
    Measured measured;
    for (auto _ : state) measured = centre_of_cube(c, mode, gather, side);
    state.counters["mean"] = measured.mean;
    state.counters["standard_error"] = measured.error;
    state.counters["off_by"] = measured.mean - c.value;
    state.counters["allowed"] = 3 * measured.error + 1e-4;
}

/// The cache is done and the camera moves: the next frame's cost, and how near it is to what it
/// converges to. Half-voxel steps are a hundred along a side of the box.
void camera_move(benchmark::State& state) {
    constexpr std::uint32_t kSide = 256;
    Scene scene{.volume = resampled(data_volume("engine"), 50)};
    scene.transfer = default_transfer(scene.volume);
    scene.environment = sky_with_sun();
    scene.view.albedo = 0.9f;
    VolumeGiParams params = picture_params(kSide, 1);
    params.mode = VolumeMode::caching;
    params.gather = false;
    params.cache_error = 0.25f; // refinement is not what is measured: it must have ended
    Renderer renderer(scene, params);
    VolumeGi& gi = renderer.gi();
    std::vector<double> cpu, gpu, decibels;
    for (auto _ : state) {
        converge(gi, 200);
        for (int i = 1; i <= 7; ++i) {
            gi.set_camera(turned(scene.camera, glm::vec3(0), UpAxis::z, 0.1f * float(i)));
            const double start = cpu_seconds();
            gi.execute();
            cpu.push_back(cpu_seconds() - start);
            gpu.push_back(1e3 * gpu_seconds(gi.executor()));
            const Image first = gi.picture();
            for (int more = 0; more < 16; ++more) gi.execute();
            decibels.push_back(image_error(first, gi.picture()).psnr);
        }
    }
    Figure(cpu).report(state, "cpu_seconds");
    Figure(gpu).report(state, "gpu_ms");
    Figure(decibels).report(state, "psnr");
    state.counters["converged"] = gi.statistics().cache_converged ? 1 : 0;
}

/// Bytes of the default cache over 14 floats for each voxel, and how near its picture is to that of
/// a cell of three floats for each voxel. Both show what is composed. The picture is of a part of
/// the volume, for all of it would take half an hour at full resolution.
void cache_memory(benchmark::State& state) {
    Scene scene = data_scene("cranium_ct");
    scene.environment = sky_with_sun();
    scene.view.albedo = 0.9f;
    VolumeGiParams params = picture_params(64, 1);
    params.mode = VolumeMode::caching;
    params.gather = false;
    VolumeStatistics whole;
    Image pictures[2];
    double converged = 1;
    for (auto _ : state) {
        scene.view.crop_min = {0, 0, 0};
        scene.view.crop_max = {1, 1, 1};
        {
            VolumeGi gi(device(), scene.volume, scene.transfer, scene.environment, scene.view,
                scene.camera, params);
            gi.execute();
            whole = gi.statistics();
        }
        scene.view.crop_min = {0.35f, 0, 0.35f};
        scene.view.crop_max = {0.65f, 1, 0.65f};
        params.cache_error = 0.15f;
        for (int i = 0; i < 2; ++i) {
            params.cache_scale = i == 0 ? 2 : 1;
            params.cache_format = i == 0 ? CacheFormat::fp16 : CacheFormat::fp32;
            Renderer renderer(scene, params);
            VolumeGi& gi = renderer.gi();
            converge(gi, 200);
            for (int more = 0; more < 16; ++more) gi.execute();
            pictures[i] = gi.picture();
            converged *= gi.statistics().cache_converged ? 1 : 0;
        }
    }
    const double paper = 56.0 * double(scene.volume.voxel_count());
    state.counters["bytes"] = double(whole.cell_bytes);
    state.counters["cells"] = double(whole.cells);
    state.counters["paper_over_bytes"] = paper / double(whole.cell_bytes);
    state.counters["psnr"] = image_error(pictures[0], pictures[1]).psnr;
    state.counters["converged"] = converged;
}

/// Slope of the logarithm of a pixel's error over that of its samples, 16 to 4096.
void convergence(benchmark::State& state, bool sobol) {
    constexpr std::uint32_t kScramblings = 16;
    Scene scene{.volume = builtin_volume("builtin:cloud", 64), .transfer = ramp(0, 1)};
    scene.transfer = default_transfer(scene.volume);
    scene.environment = sky_with_sun();
    scene.view.density_scale = 30;
    scene.view.albedo = 0.9f;
    VolumeGiParams params = picture_params(8, 16);
    params.sobol = sobol;
    Renderer renderer(scene, params);
    constexpr int kPoints = 5; // 16, 64, ... samples
    std::vector<std::vector<double>> pictures[kPoints];
    VolumeView view = scene.view;
    for (auto _ : state)
        for (std::uint32_t seed = 0; seed < kScramblings; ++seed) {
            view.seed = seed + 2;
            renderer.gi().set_view(view);
            for (int point = 0, executions = 1; point < kPoints; ++point, executions *= 4) {
                while (static_cast<int>(renderer.gi().steps()) < executions)
                    renderer.gi().execute();
                renderer.gi().finish();
                pictures[point].push_back(luminances(renderer.gi().picture()));
            }
        }
    // Slopes of independent halves of the scramblings tell how sure the slope is.
    const auto slope_of = [&](std::uint32_t first, std::uint32_t count) {
        double slope = 0;
        for (int point = 0; point < kPoints; ++point) {
            double variance = 0;
            for (std::uint32_t i = first; i < first + count; ++i)
                for (std::uint32_t j = first; j < i; ++j)
                    variance += variance_of(pictures[point][i], pictures[point][j]);
            slope += (point - 2) * std::log2(variance) / 40.0; // by least squares, 2 apart
        }
        return slope;
    };
    std::vector<double> quarters;
    for (std::uint32_t first = 0; first < kScramblings; first += 4)
        quarters.push_back(slope_of(first, 4));
    for (int point = 0; point < kPoints; ++point) // of a pair of pictures
        state.counters[fmt::format("error_{}", 16 << (2 * point))] =
            std::sqrt(variance_of(pictures[point][0], pictures[point][1]));
    state.counters["slope"] = slope_of(0, kScramblings);
    state.counters["standard_error"] = standard_error(quarters);
}

void add(const std::string& name, const std::function<void(benchmark::State&)>& body) {
    benchmark::RegisterBenchmark(name.c_str(), [body](benchmark::State& state) { body(state); })
        ->Iterations(1)
        ->Unit(benchmark::kSecond)
        ->UseRealTime();
}

void add_all() {
    benchmark::RegisterBenchmark("tracking_rate/sobol", tracking_rate)
        ->Arg(0)
        ->Arg(1)
        ->Iterations(1)
        ->Unit(benchmark::kSecond)
        ->UseRealTime();
    for (const char* volume : {"cranium_ct", "engine"})
        for (const int density : {20, 100, 400}) {
            for (const char* light : {"white", "sky", "default"})
                add(fmt::format("equal_error/{}/{}/{}", volume, light, density),
                    [=](benchmark::State& state) {
                        equal_error(state, volume, light, static_cast<float>(density));
                    });
            add(fmt::format("steps_together/{}/{}", volume, density), [=](benchmark::State& state) {
                steps_together(state, volume, static_cast<float>(density));
            });
        }
    for (const VolumeMode mode : {VolumeMode::path, VolumeMode::noncaching, VolumeMode::caching})
        for (const CubeCase& c : kCubes)
            add(fmt::format("cube/{}/albedo:{}/g:{}", name_of(mode), c.albedo, c.g),
                [=](benchmark::State& state) { cube_mean(state, c, mode, true, 64); });
    for (const bool gather : {true, false})
        for (const std::uint32_t cells : {8u, 16u, 32u})
            add(fmt::format("cells/{}/{}", gather ? "gathered" : "composed", cells),
                [=](benchmark::State& state) {
                    cube_mean(state, kCubes[1], VolumeMode::caching, gather, 2 * cells);
                });
    add("camera_move", camera_move);
    add("cache_memory", cache_memory);
    for (const bool sobol : {false, true})
        add(std::string("convergence/") + (sobol ? "sobol" : "independent"),
            [=](benchmark::State& state) { convergence(state, sobol); });
}

} // namespace
} // namespace ockham

int main(int argc, char** argv) {
    benchmark::Initialize(&argc, argv);
    try {
        ockham::log::set_level(ockham::log::Level::warning);
        ockham::add_all();
        benchmark::RunSpecifiedBenchmarks();
    } catch (const std::exception& error) {
        fmt::print(stderr, "volume_bench: {}\n", error.what());
        return 2;
    }
    return 0;
}

// SPDX-License-Identifier: Apache-2.0
#include "samples/chart/stability_suite.hpp"

#include "framework/image_error/image_error.hpp"
#include "framework/scene/builtin.hpp"
#include "passes/pipelines/aa_options.hpp"
#include "passes/pipelines/adaptive_aa.hpp"
#include "samples/chart/volume_runs.hpp"

#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>

#include <cmath>

namespace ockham::chart {
namespace {

constexpr const char* kFence = "fence";
constexpr const char* kCube = "cube";
/// Of a cube of extinction 4, albedo 0.8 and side 1 in a white world: docs/independent_truth.md.
constexpr double kCubeMean = 0.5610;
constexpr float kScales[] = {0.01f, 0.1f, 1, 10, 100};
constexpr std::uint32_t kWidth = 96, kHeight = 72;

/// Without lights, whose reach has a scale of its own.
Scene scaled_fence(float scale) {
    Scene scene = builtin_scene(kFence);
    for (Instance& instance : scene.instances)
        instance.world = glm::scale(glm::mat4(1.0f), glm::vec3(scale)) * instance.world;
    for (Camera& camera : scene.cameras) camera.position *= scale;
    scene.lights.clear();
    scene.ambient = glm::vec3(1.0f);
    return scene;
}

AdaptiveAaParams aa_picture(const std::string& method, const std::string& preset, int m) {
    AaOptions options;
    options.method = method;
    options.preset = preset;
    options.m = m;
    AdaptiveAaParams p = aa_params(options);
    p.width = kWidth;
    p.height = kHeight;
    p.history = false;
    p.export_counts = true;
    return p;
}

/// Of each square of `side` x `side` pixels.
Image averaged(const Image& image, int side) {
    Image mean(image.width() / side, image.height() / side, {"R", "G", "B"});
    for (int c = 0; c < 3; ++c)
        for (int y = 0; y < mean.height() * side; ++y)
            for (int x = 0; x < mean.width() * side; ++x)
                mean.at(x / side, y / side, c) +=
                    image.at(x, y, c) / static_cast<float>(side * side);
    return mean;
}

class StabilitySuite : public Suite {
public:
    explicit StabilitySuite(Context& context);
    std::string name() const override { return "stability"; }
    std::vector<Job> jobs() override { return list_.jobs(); }
    std::unique_ptr<Subject> open(const Job& job) override { return list_.open(job); }
    Section report(const Store& store, const std::vector<Point>& points) override;

private:
    void add(const std::string& scene, const std::string& series, const std::string& command,
        int repeats, JobList::Open open);
    std::vector<Row> counts_over_scale(const std::string& preset);
    std::vector<Row> error_over_window();
    std::vector<Row> mean_over_cells(bool gather);

    Context& context_;
    VolumeScene cloud_;
    VolumeReferences references_;
    JobList list_;
};

StabilitySuite::StabilitySuite(Context& context) : context_(context), references_(context, 64) {
    cloud_ = volume_scenes({}).front();
    cloud_.options.volume = {"builtin:cloud:48"};
    for (const char* sampler : {"independent", "sobol"}) {
        const bool sobol = std::string(sampler) == "sobol";
        add(cloud_.name, sampler,
            fmt::format("volume_gi {} --mode path --sampler {}", cloud_.flags(), sampler), 0,
            [this, sobol] {
                VolumeGiParams params;
                params.width = params.height = 64;
                params.sobol = sobol;
                return std::make_unique<VolumeRun>(context_.device(), cloud_, params,
                    references_.of(cloud_, VolumeMode::path), context_.options.quick ? 0.4 : 8);
            });
    }
    const auto once = [](auto body) {
        return [body] { return std::make_unique<Once>([body](auto&) { return body(); }); };
    };
    for (const char* preset : {"ockham", "paper"})
        add(kFence, preset, fmt::format("adaptive_aa builtin:fence --preset {}", preset), 1,
            once([this, preset] { return counts_over_scale(preset); }));
    add(kFence, "all samples", "adaptive_aa builtin:fence --method ssaa", 1,
        once([this] { return error_over_window(); }));
    for (const bool gather : {true, false})
        add(kCube, gather ? "gathered" : "composed",
            fmt::format(
                "volume_gi builtin:constant:16 --density-scale 4 --albedo 0.8 --environment "
                "1,1,1 --mode caching --gather {}",
                gather ? "on" : "off"),
            1, once([this, gather] { return mean_over_cells(gather); }));
}

void StabilitySuite::add(const std::string& scene, const std::string& series,
    const std::string& command, int repeats, JobList::Open open) {
    list_.add({.suite = name(),
                  .scene = scene,
                  .series = series,
                  .setting = {},
                  .inputs = fmt::format(
                      "{} {} {}", command, context_.options.quick, context_.device_text()),
                  .command = command,
                  .repeats = repeats},
        std::move(open));
}

std::vector<Row> StabilitySuite::counts_over_scale(const std::string& preset) {
    std::vector<Row> rows;
    for (const float scale : kScales) {
        const LitScene lit(context_.device(), scaled_fence(scale));
        AdaptiveAa aa(
            context_.device(), lit, lit.scene().cameras.front(), aa_picture("adaptive", preset, 4));
        aa.execute();
        rows.push_back({.knob = scale,
            .values = {{"scale", scale}, {"samples_percent", aa.sample_counts().percent}}});
    }
    return rows;
}

/// All m x m samples against 16 x 16: full windows of 4 x 4 in a picture four times as large.
std::vector<Row> StabilitySuite::error_over_window() {
    const LitScene lit(context_.device(), builtin_scene(kFence));
    const Camera& camera = lit.scene().cameras.front();
    AdaptiveAaParams large = aa_picture("ssaa", "ockham", 4);
    large.width *= 4;
    large.height *= 4;
    AdaptiveAa all(context_.device(), lit, camera, large);
    all.execute();
    const Image truth = averaged(all.picture(), 4);
    std::vector<Row> rows;
    for (const int m : {1, 2, 3, 4, 5, 6, 8}) {
        AdaptiveAa aa(context_.device(), lit, camera, aa_picture("ssaa", "ockham", m));
        aa.execute();
        const ImageError error = image_error(aa.picture(), truth);
        rows.push_back({.knob = double(m),
            .values = {{"m", double(m)}, {"rmse", std::sqrt(error.mse)}, {"psnr", error.psnr}}});
    }
    return rows;
}

/// Of the middle of the cube, beside what independent programs agree on.
std::vector<Row> StabilitySuite::mean_over_cells(bool gather) {
    std::vector<Row> rows;
    for (const int cells : {4, 8, 16}) {
        VolumeScene cube;
        cube.options.volume = {fmt::format("builtin:constant:{}", 2 * cells)};
        cube.options.density_scale = 4;
        cube.options.albedo = 0.8f;
        cube.options.environment = "1,1,1";
        cube.camera = "0,0,2 0,0,0 57.29577951";
        const VolumeSource source = cube.load();
        VolumeGiParams p;
        p.width = p.height = 64;
        p.samples_per_step = gather ? 32 : 4;
        p.sobol = false;
        p.mode = VolumeMode::caching;
        p.gather = gather;
        p.cache_error = 0.03f;
        VolumeGi gi(context_.device(), source.volume, source.transfer, source.environment,
            source.view, cube.view(), p);
        converge(gi, context_.options.quick ? 40 : 1000, context_.options.quick ? 6 : 300);
        for (int step = 0; step < 8 && !interrupted(); ++step) gi.execute();
        gi.finish();
        const Image picture = gi.picture();
        double mean = 0;
        for (int y = 16; y < 48; ++y)
            for (int x = 16; x < 48; ++x) mean += picture.at(x, y, 0) / (32.0 * 32.0);
        rows.push_back({.knob = double(cells),
            .values = {{"cells", double(cells)}, {"mean", mean},
                {"bias_percent", 100 * std::abs(mean / kCubeMean - 1)}}});
    }
    return rows;
}

Section StabilitySuite::report(const Store&, const std::vector<Point>& points) {
    Plot samples{.name = "stability_samples",
        .question = "Does the error fall as the root of the samples?",
        .x = {"samples", "samples per pixel", true},
        .y = {"rmse", "root of the MSE, displayed values", true, Better::less},
        .caption = "Theory: the slope of the broken line, until the reference's own error shows."};
    for (const char* sampler : {"independent", "sobol"})
        samples.curves.push_back(curve(points, cloud_.name, sampler, samples, sampler));
    if (!samples.curves.front().points.empty()) {
        Curve theory{.legend = "1 / root", .kind = Curve::Kind::limit, .points = {}};
        const PlotPoint first = samples.curves.front().points.front();
        for (const PlotPoint& point : samples.curves.front().points) {
            PlotPoint here = point;
            const double y = first.y.median / std::sqrt(point.x.median / first.x.median);
            here.y = {y, y, y};
            here.x_values.clear();
            here.y_values.clear();
            theory.points.push_back(here);
        }
        samples.curves.push_back(std::move(theory));
    }
    Plot scale{.name = "stability_scale",
        .question = "Does the scale of a scene change what is shaded?",
        .x = {"scale", "size of the scene", true},
        .y = {"samples_percent", "shaded samples (%)", false, Better::less},
        .caption =
            "builtin:fence, unlit, made larger with its camera, 4 × 4. The picture stays the "
            "same. The paper's depth term is a variance in squared units of the scene."};
    scale.curves = {curve(points, kFence, "ockham", scale, "default"),
        curve(points, kFence, "paper", scale, "as the paper")};
    Plot window{.name = "stability_window",
        .question = "Do wider windows grow exact?",
        .x = {"m", "m, of m × m samples", false},
        .y = {"rmse", "root of the MSE, displayed values", true, Better::less},
        .caption = "All m × m samples of builtin:fence against 16 × 16."};
    window.curves = {curve(points, kFence, "all samples", window, "all samples")};
    Plot cells{.name = "stability_cells",
        .question = "Do finer caches grow exact?",
        .x = {"cells", "cells along a side", true},
        .y = {"mean", "mean radiance of the middle"},
        .marks = {{.label = "known: 0.5610", .y = kCubeMean}},
        .caption =
            "A cube of extinction 4 and albedo 0.8 in a white world: on its mean independent "
            "programs agree. Noise of the cache is in it."};
    cells.curves = {curve(points, kCube, "gathered", cells, "gathered"),
        curve(points, kCube, "composed", cells, "composed")};
    return {.title = "Stability",
        .text = "Curves that theory has a word about.",
        .plots = {samples, scale, window, cells}};
}

} // namespace

std::unique_ptr<Suite> make_stability_suite(Context& context) {
    return std::make_unique<StabilitySuite>(context);
}

} // namespace ockham::chart

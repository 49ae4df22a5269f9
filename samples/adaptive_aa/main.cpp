// SPDX-License-Identifier: Apache-2.0
// adaptive_aa: renders scenes with adaptive supersampling or a reference method, and reports what
// it took. README.md beside this file has examples.
#include "framework/app/camera_path.hpp"
#include "framework/app/cli.hpp"
#include "framework/app/headless.hpp"
#include "framework/app/scene_source.hpp"
#include "framework/core/error.hpp"
#include "framework/core/log.hpp"
#include "framework/image_error/flicker.hpp"
#include "framework/image_error/mse.hpp"
#include "framework/io/image_file.hpp"
#include "passes/pipelines/adaptive_aa.hpp"

#include <nlohmann/json.hpp>

#include <charconv>
#include <cmath>
#include <limits>

using namespace ockham;

namespace {

constexpr const char* kByPreset = "preset";

struct Options {
    CommonOptions common;
    SceneOptions scene;
    CameraMoves moves;
    int m = 4;
    std::string method = "adaptive";
    int k = 1;
    std::string preset = "ockham";
    std::string metric = kByPreset;
    float lambda = kDefaultLambda;
    bool history = true;
    float budget = -1;
    std::string order = kByPreset;
    std::string dispatch = "buckets";
    std::string k_levels = "all", k_filter;
    std::string resolve = kByPreset;
    std::string gbuffer = "auto";
    int tile = 0;
    float depth_weight = -1, normal_weight = -1, shading_weight = -1; ///< < 0: by the window
    MetricsParams metrics;
    int stall = 0;
    int anisotropy = 16;
    bool aov = false;
};

void declare(Params& params, Options& o) {
    add_scene_options(params, o.scene);
    const char* kMethod = "Method";
    const auto add = [&](const char* name, Param::Target target, const char* help) -> Param& {
        return params.add(name, target, help).group(kMethod);
    };
    add("m", &o.m, "window width: m x m samples per pixel").range(1, 8);
    add("method", &o.method, "anti-aliasing")
        .choices({"none", "fxaa", "smaa", "sraa", "taa", "msaa", "cluster", "uniform", "ssaa",
            "adaptive"});
    add("k", &o.k, "samples per pixel of --method uniform").range(1, 64);
    add("preset", &o.preset,
        "metric, order and resolve at once: ockham is ockham, optimal, stratified; paper is paper, "
        "paper, prefix")
        .choices({"ockham", "paper"});
    add("metric", &o.metric, "what decides the samples per pixel")
        .choices({kByPreset, "paper", "ockham"});
    add("lambda", &o.lambda,
        "metric ockham: squared error that a sample must remove; 0: all samples, inf: one")
        .range(0, std::numeric_limits<double>::infinity());
    add("history", &o.history, "metric ockham, moving cameras: counts fall little by little")
        .on_off();
    add("c-depth", &o.depth_weight,
        "metric paper: weight of the depth variance; -1: 15 m (60 at 4 x 4)")
        .range(-1, 1e9)
        .unit("samples per squared scene unit");
    add("c-normal", &o.normal_weight,
        "metric paper: weight of the normal cone; -1: 3 m (12 at 4 x 4)")
        .range(-1, 1e9)
        .unit("samples");
    add("c-shading", &o.shading_weight,
        "metric paper: weight of the luma range; -1: 10 m (40 at 4 x 4)")
        .range(-1, 1e9)
        .unit("samples");
    add("t-min", &o.metrics.range_min, "metric paper: luma ranges below count as flat").range(0, 1);
    add("t-edge", &o.metrics.range_edge,
        "metric paper: so do ranges below this share of the brightest")
        .range(0, 1);
    add("budget", &o.budget,
        "metric ockham: samples to spend in place of --lambda, at least one a pixel; -1: by lambda")
        .range(-1, 100)
        .unit("percent of all samples");
    add("order", &o.order,
        "order of a window's samples: printed, or of least rms or least worst coverage error")
        .choices({kByPreset, "paper", "optimal", "worst"});
    add("dispatch", &o.dispatch, "how pixels of unequal counts meet the lanes of the device")
        .choices({"loop", "buckets", "repack", "stencil", "depth", "sort"});
    add("k-levels", &o.k_levels, "counts: all, or rounded up to powers of two and m x m")
        .choices({"all", "pow2"});
    add("k-filter", &o.k_filter,
        "max:N, N 1 to 64: N x N pixels share the largest of their counts");
    add("resolve", &o.resolve,
        "which samples make a pixel: the first k in order, or k shared out among its surfaces")
        .choices({kByPreset, "prefix", "stratified"});
    add("gbuffer", &o.gbuffer, "layout of the G-buffer; auto: packed where it fits")
        .choices({"auto", "packed", "visibility"});
    add("tile", &o.tile, "side of the largest screen tile; 0: the picture, or as much as fits")
        .range(0, 16384)
        .unit("pixels");
    add("anisotropy", &o.anisotropy, "most texture taps per lookup").range(1, 16);
    add("stall", &o.stall,
        "dependent multiply-adds per shaded sample, in sixteens: stands in for costly shading")
        .range(0, 500000);
    params.add("aov", &o.aov, "write k, winner, S, depth, normal, material as layers of an .exr")
        .group("Reports");
    add_view_flags(params, o.common);
    add_camera_moves(params, o.moves, "the scene");
    add_output_flags(params, o.common);
    add_frames_flag(params, o.common);
    add_run_flags(params, o.common);
}

/// Block size of "max:N"; empty: 1.
std::uint32_t parse_k_filter(const std::string& text) {
    if (text.empty()) return 1;
    std::uint32_t block = 0;
    const char* end = text.data() + text.size();
    if (!text.starts_with("max:") ||
        std::from_chars(text.data() + 4, end, block) != std::from_chars_result{end, std::errc{}} ||
        block < 1 || block > 64)
        fail_input("--k-filter: expected max:N with N from 1 to 64, found '{}'", text);
    return block;
}

/// `choice`, or what the preset says.
std::string choose(
    const Options& o, const std::string& choice, const char* ockham, const char* paper) {
    if (choice != kByPreset) return choice;
    return o.preset == "paper" ? paper : ockham;
}

AdaptiveAaParams picture_params(const Options& o, bool moving) {
    AdaptiveAaParams p;
    p.width = static_cast<std::uint32_t>(o.common.width);
    p.height = static_cast<std::uint32_t>(o.common.height);
    p.m = static_cast<std::uint32_t>(o.m);
    p.method = o.method == "none"      ? AaMethod::none
               : o.method == "fxaa"    ? AaMethod::fxaa
               : o.method == "smaa"    ? AaMethod::smaa
               : o.method == "sraa"    ? AaMethod::sraa
               : o.method == "taa"     ? AaMethod::taa
               : o.method == "msaa"    ? AaMethod::msaa
               : o.method == "cluster" ? AaMethod::cluster
               : o.method == "uniform" ? AaMethod::uniform
               : o.method == "ssaa"    ? AaMethod::ssaa
                                       : AaMethod::adaptive;
    p.k = static_cast<std::uint32_t>(o.k);
    for (const Dispatch dispatch : kDispatches) {
        if (o.dispatch == name_of(dispatch)) p.dispatch = dispatch;
    }
    p.powers_of_two = o.k_levels == "pow2";
    p.count_block = parse_k_filter(o.k_filter);
    if (o.gbuffer == "packed") p.gbuffer = GbufferLayout::packed;
    if (o.gbuffer == "visibility") p.gbuffer = GbufferLayout::visibility;
    p.tile = glm::uvec2(static_cast<std::uint32_t>(o.tile));
    p.metric =
        choose(o, o.metric, "ockham", "paper") == "ockham" ? MetricKind::ockham : MetricKind::paper;
    const std::string order = choose(o, o.order, "optimal", "paper");
    p.order_kind = order == "optimal" ? SampleOrder::optimal
                   : order == "worst" ? SampleOrder::worst
                                      : SampleOrder::paper;
    p.resolve = choose(o, o.resolve, "stratified", "prefix") == "stratified" ? Resolve::stratified
                                                                             : Resolve::prefix;
    p.lambda = o.lambda;
    p.history = o.history && moving;
    p.budget = o.budget;
    p.metrics = default_metrics(p.m);
    if (o.depth_weight >= 0) p.metrics.depth_weight = o.depth_weight;
    if (o.normal_weight >= 0) p.metrics.normal_weight = o.normal_weight;
    if (o.shading_weight >= 0) p.metrics.shading_weight = o.shading_weight;
    p.metrics.range_min = o.metrics.range_min;
    p.metrics.range_edge = o.metrics.range_edge;
    p.stall = static_cast<std::uint32_t>(o.stall);
    p.anisotropy = static_cast<std::uint32_t>(o.anisotropy);
    p.aov = o.aov;
    p.export_counts = true;
    for (const auto& [name, file] : parse_captures(o.common)) p.captures.push_back(name);
    return p;
}

void add_layer(Image& picture, const Image& source, int channel, const std::string& name) {
    const std::span<const float> from = source.plane(channel);
    std::copy(from.begin(), from.end(), picture.add_channel(name).begin());
}

/// The picture, with the layers of --aov.
Image collect_picture(AdaptiveAa& aa, const Options& o) {
    Image picture = aa.picture();
    if (!o.aov) return picture;
    const AdaptiveAaOutputs& out = aa.outputs();
    if (out.sample_count) add_layer(picture, aa.read(out.sample_count), 0, "k");
    if (out.winner) add_layer(picture, aa.read(out.winner), 0, "winner");
    if (out.first_sample) {
        const Image s = aa.read(out.first_sample);
        for (int c = 0; c < 3; ++c) add_layer(picture, s, c, fmt::format("S.{}", "RGB"[c]));
    }
    const Image surface = aa.read(out.aov_surface);
    for (int c = 0; c < 3; ++c) add_layer(picture, surface, c, fmt::format("normal.{}", "XYZ"[c]));
    add_layer(picture, surface, 3, "depth");
    add_layer(picture, aa.read(out.aov_material), 0, "material");
    return picture;
}

/// What --reference and the sample counts tell about a sequence of pictures.
class Sequence {
public:
    /// The frame that was just executed.
    void add(const Image& picture, const std::optional<Image>& reference, double percent,
        AdaptiveAa& aa) {
        nlohmann::ordered_json frame{{"percent", percent}};
        if (reference) {
            const double value = psnr(mse(displayed(picture), displayed(*reference)));
            frame["psnr"] = std::isinf(value) ? 999.0 : value;
            flicker_.add(picture, *reference);
        }
        if (const ImageHandle map = aa.outputs().sample_count) {
            Image counts = aa.read(map);
            if (!counts_.empty())
                frame["counts_changed"] = share_changed(counts_.plane(0), counts.plane(0), 2.0f);
            counts_ = std::move(counts);
        }
        frames_.push_back(std::move(frame));
    }
    double mean_of(const char* key) const {
        double sum = 0;
        int count = 0;
        for (const auto& frame : frames_)
            if (frame.contains(key)) sum += frame[key].get<double>(), ++count;
        return count > 0 ? sum / count : 0.0;
    }
    nlohmann::ordered_json to_json() const {
        return {{"frames", frames_}, {"percent", mean_of("percent")}, {"psnr", mean_of("psnr")},
            {"counts_changed", mean_of("counts_changed")}, {"flicker", flicker_.rms()}};
    }
    void print() const {
        fmt::print("frames  {:9}, {:.2f} % of the samples on average\n", frames_.size(),
            mean_of("percent"));
        fmt::print("changed {:9.2f} % of pixels by two samples or more, frame to frame\n",
            100.0 * mean_of("counts_changed"));
        if (flicker_.rms() > 0)
            fmt::print("flicker {:9.3f} codes, {:.2f} dB PSNR\n", flicker_.rms(), mean_of("psnr"));
    }

private:
    Flicker flicker_;
    Image counts_;
    nlohmann::ordered_json frames_ = nlohmann::ordered_json::array();
};

void print_summary(const FrameTimes& times, const AdaptiveAa::SampleCounts& counts,
    const std::optional<ImageError>& error) {
    fmt::print("gpu     {:9.2f} ms, shading {:.2f} ms (median of {})\n", times.total(),
        times.total_of(is_shading_pass), times.frames());
    fmt::print("samples {:9.2f} %, {:.2f} per pixel\n", counts.percent, counts.mean);
    if (error) print_error(*error);
}

nlohmann::ordered_json gbuffer_json(AdaptiveAa& aa) {
    const AdaptiveAa::Fit& fit = aa.fit();
    return {{"layout", fit.layout == GbufferLayout::packed ? "packed" : "visibility"},
        {"bytes_per_sample", gbuffer_bytes_per_sample(aa.executor().graph())},
        {"tiles", aa.tile_count()}, {"tile_width", fit.tile.x}, {"tile_height", fit.tile.y},
        {"reason", fit.reason}};
}

void check_pictures(const CommonOptions& o, std::size_t pictures) {
    check_numbered(o, pictures);
    if (pictures > 1 && !o.reference.empty() && !is_numbered(o.reference)) {
        fail_input("--reference: '{}' is one picture for {}; put a number in it, as ref%03d.exr",
            o.reference, pictures);
    }
}

int render(int argc, char** argv) {
    Options o;
    Params params;
    declare(params, o);
    if (const std::optional<int> done = parse_command_line(argc, argv,
            "Renders scenes with adaptive supersampling for deferred shading.", params, o.common)) {
        return *done;
    }
    if (o.aov && (o.common.output.empty() || !is_exr_path(o.common.output)))
        fail_input("--aov: layers need an .exr output; found '{}'", o.common.output);
    HeadlessRun run(o.common, argc, argv);

    Scene scene = load_scenes(o.scene, o.common);
    gpu::Device device(device_options(o.common));
    watch_shaders(device, o.common);
    log::info("{} ({})", device.info().name, device.info().driver_version);
    const LitScene lit(device, std::move(scene));
    const std::vector<Camera> cameras =
        choose_cameras(o.moves, o.common, choose_camera(o.common, lit.scene(), lit.gpu().bounds()),
            lit.gpu().bounds().center(), UpAxis::y, params.given("frames") ? o.common.frames : 0);
    check_pictures(o.common, cameras.size());
    AdaptiveAa aa(device, lit, cameras.front(), picture_params(o, cameras.size() > 1));
    run.announce(device, aa.executor());
    log::info("{} triangles, {} lights; scene {} MiB, graph {} MiB", lit.gpu().facts().triangles,
        lit.scene().lights.size(), lit.gpu().bytes() >> 20, aa.executor().plan().bytes_peak >> 20);

    const bool moving = cameras.size() > 1;
    if (!o.common.stats.empty() && !moving) aa.execute(); // warms up: compiles kernels
    const std::size_t frames = moving ? cameras.size() : static_cast<std::size_t>(o.common.frames);
    Sequence sequence;
    Image picture;
    AdaptiveAa::SampleCounts counts;
    int number = 0; // of the picture, in the names of files
    Progress progress("frame", frames, o.common.quiet);
    for (std::size_t frame = 0; frame < frames; ++frame) {
        if (interrupted()) return 130;
        reload_shaders(device);
        if (moving) aa.set_camera(cameras[frame]);
        aa.execute();
        if (!moving || frame > 0) run.add_times(aa.times()); // the first compiles kernels
        progress.update(frame + 1);
        if (!moving && frame + 1 < frames) continue;
        picture = collect_picture(aa, o);
        counts = aa.sample_counts();
        if (moving) number = static_cast<int>(frame);
        if (moving) sequence.add(picture, run.reference(number), counts.percent, aa);
        run.save_picture(picture, number);
    }
    expect_no_validation_messages(device);

    run.save_captures(aa.executor(), aa.outputs().captures);
    const std::optional<ImageError> error = run.error_of(picture, number);
    print_summary(run.times(), counts, error);
    nlohmann::ordered_json more{{"shading_gpu_ms", run.times().total_of(is_shading_pass)},
        {"samples",
            {{"percent", counts.percent}, {"mean_k", counts.mean}, {"histogram", counts.histogram},
                {"lane_efficiency", counts.lane_efficiency},
                {"shaded_percent", counts.shaded_percent}}}};
    more["gbuffer"] = gbuffer_json(aa);
    if (moving) {
        sequence.print();
        more["sequence"] = sequence.to_json();
    }
    run.report(device, aa.executor(), more, error);
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    return run_program([&] { return render(argc, argv); });
}

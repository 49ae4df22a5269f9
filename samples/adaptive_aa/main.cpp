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
#include "passes/pipelines/aa_options.hpp"
#include "passes/pipelines/adaptive_aa.hpp"
#include "samples/chart/aa_choice.hpp"

#include <nlohmann/json.hpp>

#include <cmath>

using namespace ockham;

namespace {

struct Options {
    CommonOptions common;
    SceneOptions scene;
    CameraMoves moves;
    AaOptions method;
    float target_psnr = 0, target_ms = 0; ///< 0: lambda as it is
    std::string chart;
    bool aov = false;
};

void declare(Params& params, Options& o) {
    add_scene_options(params, o.scene);
    add_aa_options(params, o.method);
    params
        .add("target-psnr", &o.target_psnr,
            "choose --lambda for this error, by a chart of scenes; 0: no")
        .range(0, 200)
        .unit("dB")
        .group("Method");
    params.add("target-ms", &o.target_ms, "choose --lambda for this GPU time of a frame; 0: no")
        .range(0, 1e9)
        .unit("ms")
        .group("Method");
    params.add("chart", &o.chart, "aa_chart.json of a chart to choose by; none: the built-in one")
        .group("Method");
    params.add("aov", &o.aov, "write k, winner, S, depth, normal, material as layers of an .exr")
        .group("Reports");
    add_view_flags(params, o.common);
    add_camera_moves(params, o.moves, "the scene");
    add_output_flags(params, o.common);
    add_frames_flag(params, o.common);
    add_run_flags(params, o.common);
}

AdaptiveAaParams picture_params(const Options& o, bool moving) {
    AdaptiveAaParams p = aa_params(o.method);
    p.width = static_cast<std::uint32_t>(o.common.width);
    p.height = static_cast<std::uint32_t>(o.common.height);
    p.history = p.history && moving;
    p.aov = o.aov;
    p.export_counts = true;
    for (const auto& [name, file] : parse_captures(o.common)) p.captures.push_back(name);
    return p;
}

void check_targets(const Options& o, const Params& params) {
    const bool chooses = o.target_psnr > 0 || o.target_ms > 0;
    if (!chooses && !o.chart.empty()) fail_input("--chart: needs --target-psnr or --target-ms");
    if (!chooses) return;
    if (o.target_psnr > 0 && o.target_ms > 0)
        fail_input("--target-psnr and --target-ms both choose --lambda; give one of them");
    for (const char* other : {"lambda", "budget"}) {
        if (params.given(other))
            fail_input("--target-psnr and --target-ms choose --lambda; leave --{} out", other);
    }
    const AdaptiveAaParams method = aa_params(o.method);
    if (method.method != AaMethod::adaptive || method.metric != MetricKind::ockham)
        fail_input("--target-psnr and --target-ms choose --lambda, which only --method adaptive "
                   "with --metric ockham has");
}

/// Renders the view at the default price, and takes the price from the class of scenes that this
/// is most like.
std::optional<AaChoice> choose_lambda(const Options& o, gpu::Device& device, const LitScene& scene,
    const Camera& camera, AdaptiveAaParams& params) {
    if (!(o.target_psnr > 0) && !(o.target_ms > 0)) return std::nullopt;
    const AaChart chart = o.chart.empty() ? builtin_aa_chart() : load_aa_chart(o.chart);
    if (params.m != chart.m)
        fail_input("--m: the chart is of {0} x {0} samples, not {1} x {1}", chart.m, params.m);
    AdaptiveAa aa(device, scene, camera, params);
    aa.execute(); // compiles kernels
    aa.execute();
    FrameTimes times;
    times.add(aa.times());
    const AaProbe probe{params.lambda, aa.sample_counts().percent, times.total()};
    const AaChoice choice = o.target_psnr > 0 ? choose_by_psnr(chart, probe, o.target_psnr)
                                              : choose_by_time(chart, probe, o.target_ms);
    if (!choice.reached) {
        log::warning("no lambda of the chart reaches --target-{} {:g}; the nearest is taken",
            o.target_psnr > 0 ? "psnr" : "ms", o.target_psnr > 0 ? o.target_psnr : o.target_ms);
    }
    params.lambda = static_cast<float>(choice.lambda);
    return choice;
}

nlohmann::ordered_json choice_json(const AaChoice& choice) {
    return {{"class", choice.class_name}, {"lambda", choice.lambda},
        {"predicted_psnr", choice.psnr}, {"predicted_gpu_ms", choice.total_gpu_ms},
        {"reached", choice.reached}};
}

void print_choice(
    const AaChoice& choice, const FrameTimes& times, const std::optional<ImageError>& error) {
    fmt::print("lambda  {:9.3g}, as for '{}'\n", choice.lambda, choice.class_name);
    fmt::print("predicted {:7.2f} dB, {:.2f} ms\n", choice.psnr, choice.total_gpu_ms);
    fmt::print("obtained  {}, {:.2f} ms\n",
        error ? fmt::format("{:7.2f} dB", error->psnr) : "error unknown without --reference",
        times.total());
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
    check_targets(o, params);
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
    AdaptiveAaParams asked = picture_params(o, cameras.size() > 1);
    const std::optional<AaChoice> choice = choose_lambda(o, device, lit, cameras.front(), asked);
    AdaptiveAa aa(device, lit, cameras.front(), asked);
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
    if (choice) print_choice(*choice, run.times(), error);
    nlohmann::ordered_json more{{"shading_gpu_ms", run.times().total_of(is_shading_pass)},
        {"samples",
            {{"percent", counts.percent}, {"mean_k", counts.mean}, {"histogram", counts.histogram},
                {"lane_efficiency", counts.lane_efficiency},
                {"shaded_percent", counts.shaded_percent}}}};
    more["gbuffer"] = gbuffer_json(aa);
    if (choice) more["choice"] = choice_json(*choice);
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

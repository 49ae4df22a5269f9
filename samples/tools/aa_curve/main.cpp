// SPDX-License-Identifier: Apache-2.0
// aa_curve: every anti-aliasing method on one view, swept over its knob, beside the limits that the
// full reference sets, as CSV. What the charts of error against cost are drawn from.
#include "framework/app/cli.hpp"
#include "framework/app/report.hpp"
#include "framework/app/scene_source.hpp"
#include "framework/core/file.hpp"
#include "framework/core/log.hpp"
#include "samples/chart/aa_limits.hpp"
#include "samples/chart/aa_sweep.hpp"

using namespace ockham;

namespace {

struct Options {
    CommonOptions common;
    SceneOptions scene;
    int m = 4;
    int stall = 0;
    int repeats = 3;
    std::string order = "optimal";
    std::string resolve = "stratified";
    bool limits_only = false;
    std::string out;
};

AdaptiveAaParams base_params(const Options& o) {
    AdaptiveAaParams params;
    params.width = static_cast<std::uint32_t>(o.common.width);
    params.height = static_cast<std::uint32_t>(o.common.height);
    params.m = static_cast<std::uint32_t>(o.m);
    params.stall = static_cast<std::uint32_t>(o.stall);
    params.order_kind = o.order == "optimal" ? SampleOrder::optimal : SampleOrder::paper;
    params.resolve = o.resolve == "stratified" ? Resolve::stratified : Resolve::prefix;
    params.filter_highlights = params.resolve == Resolve::stratified;
    return params;
}

AaPoint row(const char* method, const LimitPoint& limit, std::uint32_t m) {
    return {.method = method,
        .knob = limit.lambda,
        .m = m,
        .samples_percent = limit.samples_percent,
        .mse = limit.mse,
        .psnr = limit.psnr};
}

/// Both limits over lambda, from nearly all samples to nearly one.
void add_limits(
    std::vector<AaPoint>& points, const AaLimits& limits, std::span<const float> variance, int m) {
    const auto window = static_cast<std::uint32_t>(m);
    for (double lambda = 1e-6; lambda < 0.03; lambda *= 1.4)
        points.push_back(row("limit_variance", limits.by_variance(variance, lambda), window));
    for (double lambda = 1e-6; lambda < 0.03; lambda *= 1.4)
        points.push_back(row("limit_clairvoyant", limits.by_clairvoyance(lambda), window));
}

int run(int argc, char** argv) {
    Options o;
    Params params;
    add_scene_options(params, o.scene);
    const auto add = [&](const char* name, Param::Target target, const char* help) -> Param& {
        return params.add(name, target, help).group("Curves");
    };
    add("m", &o.m, "window width").range(2, 8);
    add("stall", &o.stall, "dependent multiply-adds per shaded sample").range(0, 500000);
    add("repeats", &o.repeats, "executions of each setting after one that warms up").range(1, 1000);
    add("order", &o.order, "order of a window's samples, but for the paper's method")
        .choices({"paper", "optimal"});
    add("resolve", &o.resolve, "how samples become a pixel, but for the paper's method")
        .choices({"prefix", "stratified"});
    add("limits-only", &o.limits_only, "only uniform counts and the limits computed from them");
    add("out", &o.out, "writes this .csv; without it the table is printed").transient();
    add_view_flags(params, o.common);
    add_run_flags(params, o.common);
    if (const auto done = parse_command_line(
            argc, argv, "Sweeps anti-aliasing methods over their knobs.", params, o.common)) {
        return *done;
    }
    if (!o.out.empty()) check_writable(o.out);
    Scene scene = load_scenes(o.scene, o.common);
    gpu::Device device(device_options(o.common));
    watch_shaders(device, o.common);
    const LitScene lit(device, std::move(scene));
    const Camera camera = choose_camera(o.common, lit.scene(), lit.gpu().bounds());

    const AdaptiveAaParams base = base_params(o);
    std::vector<AaSetting> settings = aa_settings(base);
    if (o.limits_only)
        std::erase_if(settings, [](const AaSetting& s) { return s.method != "uniform"; });
    const std::vector<float> variance =
        sample_variance(all_samples(device, lit, camera, base), base.m);
    AaSweep sweep(device, lit, camera, base, o.repeats);
    AaLimits limits(sweep.reference(), base.m * base.m);
    std::vector<AaPoint> points;
    Progress progress("setting", settings.size(), o.common.quiet);
    sweep.measure(
        settings, [&](const AaSetting& setting, const AaPoint& point, const Image& picture) {
            points.push_back(point);
            if (setting.method == "uniform") limits.add(setting.params.k, picture);
            progress.update(points.size());
            return !interrupted();
        });
    if (interrupted()) return 130;
    expect_no_validation_messages(device);
    add_limits(points, limits, variance, o.m);

    const std::string text = aa_csv(points);
    if (o.out.empty()) {
        fmt::print("{}", text);
    } else {
        write_text(o.out, text);
        log::info("wrote {}", o.out);
    }
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    return run_program([&] { return run(argc, argv); });
}

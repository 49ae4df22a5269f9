// SPDX-License-Identifier: Apache-2.0
#include "samples/chart/aa_suite.hpp"
#include "samples/chart/prediction.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace ockham::chart {
namespace {

/// Above, nobody sees a difference, and curves have other things to show.
constexpr double kMostPsnr = 56;

struct Method {
    const char* series;
    const char* legend;
    Curve::Kind kind = Curve::Kind::dots;
    bool competes = true;
};
/// In the order of the legend, which gives each its colour.
constexpr Method kMethods[] = {{"ockham", "adaptive", Curve::Kind::line},
    {"paper", "paper's metrics", Curve::Kind::line}, {"uniform", "uniform k", Curve::Kind::line},
    {"msaa", "MSAA"}, {"cluster", "one a surface"}, {"sraa", "SRAA"}, {"fxaa", "FXAA"},
    {"smaa", "SMAA"}, {"none", "one sample"}, {"taa", "TAA at rest", Curve::Kind::line, false}};

/// Adds to each point what follows of its times: the share of the saved samples that became saved
/// time, of the shading passes and of the whole frame.
std::vector<Point> with_captured(std::vector<Point> points) {
    for (Point& point : points) {
        if (!point.has("samples_percent") || !point.has("reference_total_gpu_ms")) continue;
        const double saved = 1 - point["samples_percent"].median / 100;
        if (saved < 0.01) continue;
        for (const char* what : {"shading", "stalled_shading", "total", "stalled_total"}) {
            const std::string name = fmt::format("{}_gpu_ms", what);
            const std::vector<double>& own = point.values[name];
            const std::vector<double>& all = point.values["reference_" + name];
            for (std::size_t i = 0; i < std::min(own.size(), all.size()); ++i)
                point.values[fmt::format("captured_{}", what)].push_back(
                    (1 - own[i] / all[i]) / saved);
        }
    }
    return points;
}

/// Median over all points of a scene.
double median_of(const std::vector<Point>& points, const std::string& scene, const char* name) {
    std::vector<double> values;
    for (const Point& point : points) {
        if (point.job->scene != scene || !point.has(name)) continue;
        values.insert(values.end(), point.values.at(name).begin(), point.values.at(name).end());
    }
    return values.empty() ? 0.0 : spread(values).median;
}

const Point* shown(
    const std::vector<Point>& points, const std::string& scene, const std::string& series) {
    const auto found = std::find_if(points.begin(), points.end(), [&](const Point& point) {
        return point.job->scene == scene && point.job->series == series &&
               point.job->setting == shown_setting(series);
    });
    return found == points.end() ? nullptr : &*found;
}

/// The frame at the default lambda; nothing where it was not measured.
std::optional<AaProbe> probe_of(const AaChart& chart) {
    if (chart.classes.empty()) return std::nullopt;
    for (const AaClass::Entry& entry : chart.classes.front().entries)
        if (fmt::format("{:g}", entry.lambda) == shown_setting("ockham"))
            return AaProbe{entry.lambda, entry.samples_percent, entry.total_gpu_ms};
    return std::nullopt;
}

std::string setting_of(const AaChoice& choice) {
    return fmt::format("{:.3g} by {}", choice.lambda, choice.class_name);
}

/// What a choice by the program's chart, without the class of the scene itself, asks for and gets.
class Prediction {
public:
    Prediction(const std::vector<Point>& points, const std::vector<std::string>& scenes) {
        for (const std::string& scene : scenes) add(points, scene);
        by_psnr_.curves.push_back(as_asked(by_psnr_));
        by_time_.curves.push_back(as_asked(by_time_));
    }
    std::vector<Plot> plots() const {
        if (by_psnr_.curves.size() < 2) return {};
        return {by_psnr_, by_time_};
    }

private:
    void add(const std::vector<Point>& points, const std::string& scene) {
        const AaChart own = aa_chart_of(points, {scene}, "");
        const std::optional<AaProbe> probe = probe_of(own);
        AaChart others = builtin_aa_chart();
        std::erase_if(others.classes, [&](const AaClass& c) { return c.name == scene; });
        if (!probe || others.classes.empty()) return;
        Curve psnr{.legend = scene}, time{.legend = scene};
        for (double asked = 34; asked <= 52; asked += 2) {
            const AaChoice choice = choose_by_psnr(others, *probe, asked);
            const AaChoice got = predict(own.classes.front(), *probe, choice.lambda);
            if (choice.reached)
                psnr.points.push_back(obtained(asked, got.psnr, setting_of(choice)));
        }
        for (double share = 0.5; share <= 1.5; share += 0.1) {
            const double asked = share * probe->total_gpu_ms;
            const AaChoice choice = choose_by_time(others, *probe, asked);
            const AaChoice got = predict(own.classes.front(), *probe, choice.lambda);
            if (choice.reached)
                time.points.push_back(obtained(asked, got.total_gpu_ms, setting_of(choice)));
        }
        by_psnr_.curves.push_back(std::move(psnr));
        by_time_.curves.push_back(std::move(time));
    }

    Plot by_psnr_{.name = "aa_choice_psnr",
        .question = "Does --target-psnr give what was asked for?",
        .x = {"asked_psnr", "PSNR asked for (dB)"},
        .y = {"psnr", "PSNR obtained (dB)"},
        .caption = "λ is chosen by the curve of another scene, the one whose share of samples is "
                   "nearest in one frame at the default. The scene itself is left out."};
    Plot by_time_{.name = "aa_choice_ms",
        .question = "Does --target-ms give what was asked for?",
        .x = {"asked_ms", "GPU time asked for (ms a frame)", true},
        .y = {"ms", "GPU time obtained (ms a frame)", true},
        .caption = "Likewise. Where less was asked for than any setting of that scene takes, there "
                   "is no point."};
};

class SceneReport {
public:
    SceneReport(const std::vector<Point>& points, std::string scene)
        : points_(points), scene_(std::move(scene)) {}

    /// Error of every method against what it costs.
    Plot methods(const char* name, Axis x, Axis y, const std::string& question,
        const std::string& caption) const {
        Plot plot{.name = "aa_" + stem_of(scene_) + name,
            .question = question + ": " + scene_,
            .x = std::move(x),
            .y = std::move(y),
            .caption = caption};
        for (const Method& method : kMethods) {
            plot.curves.push_back(
                curve(points_, scene_, method.series, plot, method.legend, method.kind));
            plot.curves.back().competes = method.competes;
        }
        if (const Point* point = shown(points_, scene_, "ockham");
            point != nullptr && point->has(plot.x.value) && point->has(plot.y.value)) {
            plot.marks.push_back({.label = "default",
                .x = (*point)[plot.x.value].median,
                .y = (*point)[plot.y.value].median});
        }
        return plot;
    }

    /// Where the targets would set lambda, on a chart of PSNR against time.
    void mark_targets(Plot& plot, const ChartOptions& options) const {
        const AaChart own = aa_chart_of(points_, {scene_}, "");
        const std::optional<AaProbe> probe = probe_of(own);
        if (!probe) return;
        const auto mark = [&](const AaChoice& choice, const std::string& label) {
            if (choice.reached)
                plot.marks.push_back({.label = label, .x = choice.total_gpu_ms, .y = choice.psnr});
        };
        if (options.target_psnr > 0) {
            mark(choose_by_psnr(own, *probe, options.target_psnr),
                fmt::format("{:g} dB", options.target_psnr));
        }
        if (options.target_ms > 0) {
            mark(choose_by_time(own, *probe, options.target_ms),
                fmt::format("{:g} ms", options.target_ms));
        }
    }

    /// What could be done by who knows the reference. In time: at `fixed_ms` and a share of
    /// `shading_ms` equal to that of the samples, as if choosing cost nothing.
    void add_limits(Plot& plot, double fixed_ms, double shading_ms) const {
        for (const auto& [name, legend] :
            {std::pair{"variance", "variance known"}, std::pair{"clairvoyant", "errors known"}}) {
            Plot in_percent = plot;
            in_percent.x.value = fmt::format("{}_samples_percent", name);
            in_percent.y.value = fmt::format("{}_psnr", name);
            Curve limit = curve(points_, scene_, "limits", in_percent, legend, Curve::Kind::limit);
            if (shading_ms > 0) {
                for (PlotPoint& point : limit.points) {
                    const double ms = fixed_ms + shading_ms * point.x.median / 100;
                    point.x = {ms, ms, ms};
                    point.x_values = {ms};
                }
            }
            plot.curves.push_back(std::move(limit));
        }
    }

    Plot against_samples() const {
        Plot plot = methods("_samples",
            {"samples_percent", "shaded samples (% of 4 × 4)", true, Better::less},
            {"psnr", "PSNR against all 4 × 4 samples (dB)", false, Better::more, kMostPsnr},
            "Error against samples",
            "The knob of each curve buys accuracy with samples. The limits were computed from the "
            "full reference: the least error at each budget of somebody who knows every pixel's "
            "variance, and of somebody who knows every pixel's error, luck included. TAA gathers 2 "
            "to 16 frames of a camera at rest.");
        add_limits(plot, 0, 0);
        return plot;
    }

    Plot against_time(bool stalled) const {
        const std::string prefix = stalled ? "stalled_" : "";
        Plot plot = methods(stalled ? "_stalled_ms" : "_ms",
            {prefix + "total_gpu_ms",
                stalled ? "GPU time, stalled shading (ms a frame)" : "GPU time (ms a frame)", true,
                Better::less},
            {"psnr", "PSNR against all 4 × 4 samples (dB)", false, Better::more, kMostPsnr},
            stalled ? "Error against time, costly shading" : "Error against time",
            stalled ? fmt::format(
                          "{} dependent multiply-adds were added to each shaded sample.", kAaStall)
                    : "Whole frames, rasterisation of the 4 × 4 G-buffer included.");
        const auto median = [&](const char* what) {
            return median_of(
                points_, scene_, fmt::format("reference_{}{}_gpu_ms", prefix, what).c_str());
        };
        const double total = median("total"), shading = median("shading");
        if (total <= 0) return plot;
        add_limits(plot, total - shading, shading);
        plot.marks.push_back({.label = "all 4 × 4 samples", .x = total, .y = {}});
        plot.caption += " The limits take their share of the reference's shading time, and nothing "
                        "for choosing.";
        return plot;
    }

    Plot seen() const {
        return methods("_flip", {"total_gpu_ms", "GPU time (ms a frame)", true, Better::less},
            {"flip", "mean FLIP against all 4 × 4 samples", true, Better::less},
            "Visible error against time",
            "FLIP is what a viewer sees when flipping between the pictures; lower is better.");
    }

    Plot true_error() const {
        Plot plot = methods("_true", {"total_gpu_ms", "GPU time (ms a frame)", true, Better::less},
            {"fine_psnr", "PSNR against 16 × 16 samples (dB)", false, Better::more},
            "Error against the truth",
            "Against 256 samples a pixel, full supersampling at 4 × 4 has an error of its own: "
            "the dotted line. What comes near it need not come nearer.");
        if (const Point* all = shown(points_, scene_, "ssaa"); all != nullptr)
            plot.marks.push_back(
                {.label = "all 4 × 4 samples", .x = {}, .y = (*all)["fine_psnr"].median});
        return plot;
    }

    /// One curve for each way to dispatch; none where they were not measured on this scene.
    Plot dispatches(const char* name, const char* value, const std::string& label,
        const std::string& question, const std::string& caption) const {
        Plot plot{.name = "aa_" + stem_of(scene_) + name,
            .question = question + ": " + scene_,
            .x = {"samples_percent", "shaded samples (% of 4 × 4)"},
            .y = {value, label, false, Better::neither},
            .caption = caption};
        for (const char* scheme : {"buckets", "loop", "repack", "stencil", "depth", "sort"}) {
            plot.curves.push_back(
                curve(points_, scene_, fmt::format("dispatch {}", scheme), plot, scheme));
        }
        std::erase_if(plot.curves, [](const Curve& c) { return c.points.empty(); });
        return plot;
    }

    Table table() const {
        Table table{.name = "aa_" + stem_of(scene_) + "_table",
            .title = "Methods at their defaults: " + scene_,
            .columns = {"method", "knob", "samples %", "frame ms", "shading ms", "stalled frame ms",
                "stalled shading ms", "PSNR dB", "SSIM", "FLIP", "PSNR dB, 16 × 16", "captured",
                "whole frame"},
            .caption =
                "<i>Captured</i>: (1 − time ratio) / (1 − sample ratio) of the shading passes "
                "with stalled shading; beside it, of whole frames. 1: every sample saved is "
                "time saved."};
        std::vector<Method> rows(std::begin(kMethods), std::end(kMethods));
        rows.push_back({"ssaa", "all 4 × 4 samples"});
        for (const Method& method : rows) {
            const Point* point = shown(points_, scene_, method.series);
            if (point == nullptr) continue;
            const auto number = [&](const char* value, const char* format) {
                return point->has(value) ? fmt::format(fmt::runtime(format), (*point)[value].median)
                                         : "";
            };
            const bool saves = needs_counts_text(method.series);
            table.rows.push_back({method.legend, point->job->setting,
                number("samples_percent", "{:.1f}"), number("total_gpu_ms", "{:.1f}"),
                number("shading_gpu_ms", "{:.1f}"), number("stalled_total_gpu_ms", "{:.1f}"),
                number("stalled_shading_gpu_ms", "{:.1f}"),
                (*point)["psnr"].median >= 999 ? "∞" : number("psnr", "{:.2f}"),
                number("ssim", "{:.4f}"), number("flip", "{:.4f}"), number("fine_psnr", "{:.2f}"),
                saves ? number("captured_stalled_shading", "{:.2f}") : "",
                saves ? number("captured_stalled_total", "{:.2f}") : ""});
        }
        return table;
    }

    Wipe wipe(const Store& store) const {
        Wipe wipe{.title = scene_ + ".",
            .caption = "Move over the picture; choose what stands on either side, or look at the "
                       "errors against all 4 × 4 samples."};
        const auto pictures_of = [&](const char* series) {
            const Point* point = shown(points_, scene_, series);
            return point == nullptr ? std::map<std::string, std::string>()
                                    : store.repeats(*point->job).front().pictures;
        };
        const std::string all = pictures_of("ssaa")["picture"];
        const auto add = [&](const char* series, const char* legend) {
            const auto pictures = pictures_of(series);
            if (!pictures.contains("picture")) return;
            wipe.sides.push_back({.label = legend,
                .picture = pictures.at("picture"),
                .error_map = pictures.at("error"),
                .reference = all});
        };
        add("ockham", "adaptive");
        add("none", "one sample");
        add("ssaa", "all 4 × 4 samples");
        for (const Method& method : kMethods)
            if (method.series != std::string("ockham") && method.series != std::string("none"))
                add(method.series, method.legend);
        return wipe;
    }

private:
    static bool needs_counts_text(const std::string& series) {
        return series == "ockham" || series == "paper" || series == "uniform";
    }

    const std::vector<Point>& points_;
    std::string scene_;
};

} // namespace

AaChart aa_chart_of(const std::vector<Point>& points, const std::vector<std::string>& scenes,
    const std::string& device) {
    AaChart chart{.m = 4, .device = device, .classes = {}};
    for (const std::string& scene : scenes) {
        AaClass measured{.name = scene, .entries = {}};
        for (const Point& point : points) {
            if (point.job->scene != scene || point.job->series != "ockham") continue;
            if (!point.has("psnr") || !point.has("total_gpu_ms")) continue;
            measured.entries.push_back({point.knob, point["samples_percent"].median,
                point["psnr"].median, point["total_gpu_ms"].median});
        }
        if (measured.entries.size() > 1) chart.classes.push_back(std::move(measured));
    }
    return chart;
}

Section aa_report(const Context& context, const Store& store, const std::vector<Point>& measured,
    const std::vector<std::string>& scenes) {
    const std::vector<Point> points = with_captured(measured);
    Section section{.title = "Anti-aliasing",
        .text = fmt::format("Deferred shading at {} × {} pixels with windows of 4 × 4 samples, of "
                            "which methods shade "
                            "all or some. Error is of sRGB-encoded colours, peak 1.",
            context.options.common.width, context.options.common.height)};
    for (const std::string& scene : scenes) {
        const SceneReport report(points, scene);
        Plot time = report.against_time(false);
        report.mark_targets(time, context.options);
        for (Plot& plot : std::vector<Plot>{report.against_samples(), time,
                 report.against_time(true), report.seen(), report.true_error()}) {
            section.plots.push_back(std::move(plot));
        }
        Plot lanes = report.dispatches("_lanes", "lane_efficiency", "useful share of SIMD lanes",
            "Lanes in use by each dispatch",
            "Computed from the counts for groups of 8 lanes that work as long as their longest.");
        if (lanes.curves.empty()) continue;
        section.plots.push_back(std::move(lanes));
        section.plots.push_back(report.dispatches("_captured", "captured_stalled_shading",
            "captured saving, shading passes", "Saved samples that became saved time",
            "(1 − time ratio) / (1 − sample ratio) of the shading passes with stalled shading. At "
            "1, "
            "every sample saved is time saved."));
        section.plots.push_back(report.dispatches("_captured_frame", "captured_stalled_total",
            "captured saving, whole frame", "The same, of whole frames",
            "With the G-buffer, which no method saves. The paper reports 0.15 to 0.36 on its "
            "GPU."));
    }
    for (Plot& plot : Prediction(points, scenes).plots()) section.plots.push_back(std::move(plot));
    for (const std::string& scene : scenes) {
        section.tables.push_back(SceneReport(points, scene).table());
        section.wipes.push_back(SceneReport(points, scene).wipe(store));
    }
    return section;
}

} // namespace ockham::chart

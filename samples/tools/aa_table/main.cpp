// SPDX-License-Identifier: Apache-2.0
// aa_table: table 1 of Hollaender et al. 2013 on any scene: reference, adaptive as the paper
// has it and as is default here, for several window widths, with cheap and with stalled shading, as
// Markdown and CSV. Rows that are compared are executed in turns, so that a noisy machine hurts
// both alike.
#include "framework/app/cli.hpp"
#include "framework/app/report.hpp"
#include "framework/app/scene_source.hpp"
#include "framework/core/error.hpp"
#include "framework/core/file.hpp"
#include "framework/core/log.hpp"
#include "framework/image_error/image_error.hpp"
#include "passes/pipelines/adaptive_aa.hpp"

#include <array>
#include <cmath>
#include <memory>

using namespace ockham;

namespace {

struct Options {
    CommonOptions common;
    SceneOptions scene;
    int m_max = 4;
    int stall = 2000;
    int repeats = 3;
    bool back_ends = false;
    std::string out;
    float lambda = kDefaultLambda;
    float depth_weight = -1, normal_weight = -1, shading_weight = -1; ///< < 0: by the window
};

/// One configuration, with its times under cheap and stalled shading.
struct Row {
    AaMethod method = AaMethod::none;
    std::uint32_t m = 1;
    Dispatch dispatch = Dispatch::buckets; ///< adaptive only
    MetricKind metric = MetricKind::paper; ///< adaptive only: its preset
    std::array<FrameTimes, 2> times{};     ///< cheap, stalled
    AdaptiveAa::SampleCounts counts{};
    std::optional<ImageError> error{}; ///< against the reference of the same m

    double shading(std::size_t stalled) const { return times[stalled].total_of(is_shading_pass); }
    std::string supersampling() const { return fmt::format("{0}x{0}", m); }
    std::string name() const {
        if (method == AaMethod::ssaa) return "Reference";
        if (method != AaMethod::adaptive) return "Default";
        return fmt::format("{}, {}",
            metric == MetricKind::paper ? "Adaptive, as the paper" : "Adaptive", name_of(dispatch));
    }
};

/// The rows of one window width; the first is the reference.
std::vector<Row> rows_of(std::uint32_t m, bool back_ends, const gpu::Device& device) {
    if (m == 1) return {{.method = AaMethod::none, .m = 1}};
    std::vector<Row> rows{{.method = AaMethod::ssaa, .m = m}};
    for (const Dispatch dispatch : kDispatches) {
        if (dispatch != AdaptiveAaParams{}.dispatch && !back_ends) continue;
        if (dispatch == Dispatch::stencil && !device.exports_stencil()) continue;
        for (const MetricKind metric : {MetricKind::paper, MetricKind::ockham}) {
            rows.push_back(
                {.method = AaMethod::adaptive, .m = m, .dispatch = dispatch, .metric = metric});
        }
    }
    return rows;
}

class TableMaker {
public:
    TableMaker(gpu::Device& device, const LitScene& scene, const Camera& camera, const Options& o)
        : device_(device), scene_(scene), camera_(camera), options_(o) {}

    /// Executes the rows in turns, `repeats` times after one warm-up each; the first is the
    /// reference of the others' error.
    void measure(std::vector<Row>& rows) {
        Image reference;
        for (const std::size_t stalled : {std::size_t{0}, std::size_t{1}}) {
            std::vector<std::unique_ptr<AdaptiveAa>> pictures;
            for (Row& row : rows) {
                pictures.push_back(std::make_unique<AdaptiveAa>(
                    device_, scene_, camera_, params(row, stalled != 0)));
                pictures.back()->execute();
            }
            for (int repeat = 0; repeat < options_.repeats; ++repeat) {
                for (std::size_t i = 0; i < rows.size(); ++i) {
                    if (interrupted()) return;
                    pictures[i]->execute();
                    rows[i].times[stalled].add(pictures[i]->executor().times());
                }
            }
            if (stalled != 0) continue;
            for (std::size_t i = 0; i < rows.size(); ++i) {
                rows[i].counts = pictures[i]->sample_counts();
                if (i == 0)
                    reference = pictures[i]->picture();
                else
                    rows[i].error = image_error(pictures[i]->picture(), reference);
            }
        }
    }

private:
    AdaptiveAaParams params(const Row& row, bool stalled) const {
        AdaptiveAaParams p;
        p.width = static_cast<std::uint32_t>(options_.common.width);
        p.height = static_cast<std::uint32_t>(options_.common.height);
        p.m = row.m;
        p.method = row.method;
        p.dispatch = row.dispatch;
        p.metric = row.metric;
        if (row.metric == MetricKind::ockham) {
            p.order_kind = SampleOrder::optimal;
            p.resolve = Resolve::stratified;
            p.filter_highlights = true;
            p.lambda = options_.lambda;
        }
        p.metrics = default_metrics(row.m);
        if (options_.depth_weight >= 0) p.metrics.depth_weight = options_.depth_weight;
        if (options_.normal_weight >= 0) p.metrics.normal_weight = options_.normal_weight;
        if (options_.shading_weight >= 0) p.metrics.shading_weight = options_.shading_weight;
        p.stall = stalled ? static_cast<std::uint32_t>(options_.stall) : 0;
        p.export_counts = true;
        return p;
    }

    gpu::Device& device_;
    const LitScene& scene_;
    Camera camera_;
    const Options& options_;
};

/// (1 - time ratio) / (1 - sample ratio): the share of the saved samples that became saved time.
double captured(const Row& adaptive, const Row& reference, std::size_t stalled, bool whole_frame) {
    const double ratio = whole_frame
                             ? adaptive.times[stalled].total() / reference.times[stalled].total()
                             : adaptive.shading(stalled) / reference.shading(stalled);
    return (1.0 - ratio) / (1.0 - adaptive.counts.percent / 100.0);
}

std::string markdown(const std::vector<Row>& rows, const std::string& heading) {
    std::string text =
        heading +
        "| Supersampling | Method | ms/frame | stalled ms | shading ms | stalled shading ms | MSE "
        "x1e-5 "
        "| PSNR dB (peak 1) | PSNR dB (paper's convention) | samples % | lane efficiency "
        "| captured | captured, stalled | whole frame | whole frame, stalled |\n"
        "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
    const Row* reference = nullptr;
    for (const Row& row : rows) {
        if (row.method == AaMethod::ssaa) reference = &row;
        text += fmt::format("| {} | {} | {:.1f} | {:.1f} | {:.1f} | {:.1f} ", row.supersampling(),
            row.name(), row.times[0].total(), row.times[1].total(), row.shading(0), row.shading(1));
        if (row.method != AaMethod::adaptive || reference == nullptr) {
            text += fmt::format("| | | | {:.1f} | | | | | |\n", row.counts.percent);
            continue;
        }
        text += fmt::format("| {:.2f} | {:.2f} | {:.2f} | {:.1f} | {:.3f} ", 1e5 * row.error->mse,
            row.error->psnr, row.error->psnr + 20.0 * std::log10(255.0), row.counts.percent,
            row.counts.lane_efficiency);
        text += fmt::format("| {:.2f} | {:.2f} | {:.2f} | {:.2f} |\n",
            captured(row, *reference, 0, false), captured(row, *reference, 1, false),
            captured(row, *reference, 0, true), captured(row, *reference, 1, true));
    }
    return text;
}

std::string csv(const std::vector<Row>& rows) {
    std::string text =
        "m,method,total_gpu_ms,stalled_total_gpu_ms,shading_gpu_ms,stalled_shading_gpu_ms,mse,"
        "psnr,ssim,flip,samples_percent,shaded_percent,lane_efficiency\n";
    for (const Row& row : rows) {
        text += fmt::format("{},\"{}\",{},{},{},{},", row.m, row.name(), row.times[0].total(),
            row.times[1].total(), row.shading(0), row.shading(1));
        text += row.error ? fmt::format("{},{},{},{},", row.error->mse, row.error->psnr,
                                row.error->ssim, row.error->flip.mean)
                          : ",,,,";
        text += fmt::format("{},{},{}\n", row.counts.percent, row.counts.shaded_percent,
            row.counts.lane_efficiency);
    }
    return text;
}

int run(int argc, char** argv) {
    Options o;
    Params params;
    add_scene_options(params, o.scene);
    params.add("m-max", &o.m_max, "window widths 2 ... this one").range(2, 8).group("Table");
    params.add("stall", &o.stall, "dependent multiply-adds per sample in the stalled columns")
        .range(16, 500000)
        .group("Table");
    params.add("repeats", &o.repeats, "executions of each row after one that warms up")
        .range(1, 1000)
        .group("Table");
    params.add("back-ends", &o.back_ends, "a row for every --dispatch of adaptive_aa")
        .group("Table");
    params.add("out", &o.out, "writes this .md and this .csv").group("Table").transient();
    params.add("lambda", &o.lambda, "price of a sample: squared error that it must remove")
        .range(0, 1)
        .group("Table");
    params.add("c-depth", &o.depth_weight, "as the paper: weight of the depth variance; -1: 15 m")
        .range(-1, 1e9)
        .group("Table");
    params.add("c-normal", &o.normal_weight, "as the paper: weight of the normal cone; -1: 3 m")
        .range(-1, 1e9)
        .group("Table");
    params.add("c-shading", &o.shading_weight, "as the paper: weight of the luma range; -1: 10 m")
        .range(-1, 1e9)
        .group("Table");
    add_view_flags(params, o.common);
    add_run_flags(params, o.common);
    if (const auto done = parse_command_line(argc, argv,
            "Measures adaptive supersampling against full supersampling.", params, o.common)) {
        return *done;
    }
    if (!o.out.empty()) {
        check_writable(o.out + ".md");
        check_writable(o.out + ".csv");
    }
    Scene scene = load_scenes(o.scene, o.common);
    gpu::Device device(device_options(o.common));
    watch_shaders(device, o.common);
    const LitScene lit(device, std::move(scene));
    const Camera camera = choose_camera(o.common, lit.scene(), lit.gpu().bounds());
    TableMaker table(device, lit, camera, o);

    std::vector<Row> rows;
    Progress progress("window width", static_cast<std::size_t>(o.m_max), o.common.quiet);
    for (std::uint32_t m = 1; m <= static_cast<std::uint32_t>(o.m_max); ++m) {
        if (m > 4 && m != 8) continue; // widths without a printed order
        std::vector<Row> group = rows_of(m, o.back_ends, device);
        table.measure(group);
        if (interrupted()) return 130;
        for (Row& row : group) rows.push_back(std::move(row));
        progress.update(m);
    }
    expect_no_validation_messages(device);
    const std::string heading = fmt::format("`{}`\n\n{} ({}), {} x {} pixels, {} triangles, {} "
                                            "lights; medians of {} executions; stall {} "
                                            "FMAs per sample.\n\n",
        command_text(argc, argv), device.info().name, device.info().driver_version, o.common.width,
        o.common.height, lit.gpu().facts().triangles, lit.scene().lights.size(), o.repeats,
        o.stall);
    const std::string text = markdown(rows, heading);
    fmt::print("{}", text);
    if (!o.out.empty()) {
        write_text(o.out + ".md", text);
        write_text(o.out + ".csv", csv(rows));
        log::info("wrote {0}.md and {0}.csv", o.out);
    }
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    return run_program([&] { return run(argc, argv); });
}

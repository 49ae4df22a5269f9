// SPDX-License-Identifier: Apache-2.0
#include "samples/chart/paper_aa.hpp"

#include "framework/app/scene_source.hpp"
#include "framework/core/false_color.hpp"
#include "framework/image_error/image_error.hpp"
#include "samples/chart/paper_numbers.hpp"

#include <fmt/format.h>

#include <cmath>

namespace ockham::chart {
namespace {

constexpr std::uint32_t kStall = 2000;     ///< multiply-adds per sample, in the stalled columns
constexpr std::uint32_t kFigureWindow = 3; ///< figures 5 and 8 are of 3 x 3

std::string window_series(std::uint32_t m, std::uint32_t stall = 0) {
    return fmt::format("table 1, {0} x {0}{1}", m, stall > 0 ? ", stalled" : "");
}

Picture count_picture(const Image& counts, std::uint32_t m) {
    return {counts.width(), counts.height(),
        false_color(counts.plane(0), 1.0f, static_cast<float>(m * m))};
}

double milliseconds(const std::vector<PassTime>& times, bool (*counts)(std::string_view)) {
    double sum = 0;
    for (const PassTime& time : times)
        if (counts == nullptr || counts(time.pass)) sum += time.milliseconds;
    return sum;
}

/// What a picture costs in samples, and how far it is from the reference.
Values errors_of(AdaptiveAa& aa, std::uint32_t m, const Image& reference) {
    const ImageError error = image_error(aa.picture(), reference);
    return {{"samples_percent", 100.0 * aa.sample_counts().mean / (m * m)},
        {"mse_1e5", 1e5 * error.mse}, {"psnr", error.psnr}, {"ssim", error.ssim},
        {"flip", error.flip.mean}};
}

std::string cell(double value, const char* format = "{:.2f}") {
    return std::isnan(value) ? "" : fmt::format(fmt::runtime(format), value);
}
std::string cell(const Point* point, const char* value, const char* format = "{:.2f}") {
    return point == nullptr || !point->has(value) ? "" : cell((*point)[value].median, format);
}

} // namespace

/// The rows of one window width, executed in turns, so that a noisy machine hurts all alike. m = 1:
/// one sample, FXAA. Else: all samples, as the paper, by default.
class PaperAa::Window : public Subject {
public:
    Window(PaperAa& owner, std::uint32_t m, std::uint32_t stall) : m_(m), stall_(stall) {
        std::vector<AdaptiveAaParams> rows;
        if (m == 1)
            rows = {owner.params(1, "none"), owner.params(1, "fxaa")};
        else
            rows = {owner.params(m, "ssaa"), owner.as_paper(m), owner.as_default(m)};
        const LitScene& lit = owner.lit();
        for (AdaptiveAaParams& params : rows) {
            params.stall = stall;
            pictures_.push_back(
                std::make_unique<AdaptiveAa>(owner.context_.device(), lit, owner.camera_, params));
            pictures_.back()->execute();
        }
        reference_ = pictures_.front()->picture();
        AdaptiveAa one(owner.context_.device(), lit, owner.camera_, owner.params(1, "none"));
        one.execute();
        one_sample_ = one.picture();
    }

    std::vector<Row> measure() override {
        std::vector<Row> rows;
        for (const auto& aa : pictures_) {
            if (interrupted()) break;
            aa->execute();
            Row row{.knob = static_cast<double>(rows.size()),
                .values = {{"total_gpu_ms", milliseconds(aa->times(), nullptr)},
                    {"shading_gpu_ms", milliseconds(aa->times(), is_shading_pass)}}};
            row.values.merge(errors_of(*aa, m_, reference_));
            rows.push_back(std::move(row));
        }
        return rows;
    }

    std::map<std::string, Picture> pictures() override {
        if (stall_ > 0) return {}; // the same ones
        std::map<std::string, Picture> shown{{"reference", to_picture(reference_)},
            {"one", to_picture(one_sample_)},
            {"one_error", error_picture(one_sample_, reference_)}};
        if (m_ == 1) return shown;
        for (const auto& [at, title] : {std::pair(1, "paper"), std::pair(2, "ockham")}) {
            AdaptiveAa& aa = *pictures_[static_cast<std::size_t>(at)];
            const Image picture = aa.picture();
            const std::string prefix = title;
            shown[prefix] = to_picture(picture);
            shown[prefix + "_error"] = error_picture(picture, reference_);
            shown[prefix + "_counts"] = count_picture(aa.read(aa.outputs().sample_count), m_);
        }
        return shown;
    }

private:
    std::uint32_t m_, stall_;
    std::vector<std::unique_ptr<AdaptiveAa>> pictures_;
    Image reference_, one_sample_;
};

PaperAa::PaperAa(Context& context, JobList& list)
    : context_(context),
      scene_(context.options.scenes.empty() ? "builtin:atrium" : context.options.scenes.front()),
      rig_(scene_.starts_with("builtin:") ? "" : context.options.rig),
      width_(static_cast<std::uint32_t>(context.options.common.width)),
      height_(static_cast<std::uint32_t>(context.options.common.height)) {
    const auto add = [&](Job job, JobList::Open open) {
        jobs_.push_back(job);
        list.add(std::move(job), std::move(open));
    };
    for (const std::uint32_t m : {1u, 2u, 3u, 4u})
        for (const std::uint32_t stall : {0u, kStall}) {
            add(job(window_series(m, stall),
                    fmt::format("--m {} --preset paper --stall {}", m, stall), 0),
                [this, m, stall] { return std::make_unique<Window>(*this, m, stall); });
        }
    add(job("figure 5", "--m 3 --preset paper --anisotropy 1", 1),
        [this] { return std::make_unique<Once>([this](auto& shown) { return figure_5(shown); }); });
    add(job("figure 8", "--m 3 --preset paper --c-shading 0", 1),
        [this] { return std::make_unique<Once>([this](auto& shown) { return figure_8(shown); }); });
    add(job("dispatch", "--m 3 --preset paper --dispatch sort", 1),
        [this] { return std::make_unique<Once>([this](auto&) { return dispatches(); }); });
}

Job PaperAa::job(const std::string& series, const std::string& flags, int repeats) const {
    return {.suite = "papers",
        .scene = scene_,
        .series = series,
        .setting = {},
        .inputs = fmt::format("{} {} {} {} x {} {}", fingerprint_of(scene_),
            rig_.empty() ? "" : fingerprint_of(rig_), flags, width_, height_,
            context_.device_text()),
        .command = fmt::format("adaptive_aa {}{} {} --width {} --height {}", scene_,
            rig_.empty() ? "" : " --rig " + rig_, flags, width_, height_),
        .repeats = repeats};
}

const LitScene& PaperAa::lit() {
    if (!lit_) {
        lit_ = std::make_unique<LitScene>(
            context_.device(), load_scenes({.scenes = {scene_}, .rig = rig_, .environment = {}},
                                   context_.options.common));
        camera_ = choose_camera(context_.options.common, lit_->scene(), lit_->gpu().bounds());
    }
    return *lit_;
}

AdaptiveAaParams PaperAa::params(
    std::uint32_t m, const std::string& method, const std::string& preset) const {
    AaOptions options;
    options.m = static_cast<int>(m);
    options.method = method;
    options.preset = preset;
    AdaptiveAaParams p = aa_params(options);
    p.width = width_;
    p.height = height_;
    p.history = false; // the camera stands still
    p.export_counts = true;
    return p;
}

AdaptiveAaParams PaperAa::as_paper(std::uint32_t m) const {
    AdaptiveAaParams p = params(m, "adaptive", "paper");
    p.gbuffer = GbufferLayout::packed;
    return p;
}

AdaptiveAaParams PaperAa::as_default(std::uint32_t m) const { return params(m, "adaptive"); }

/// Anisotropic lookups, and without: both against all samples with them.
std::vector<Row> PaperAa::figure_5(std::map<std::string, Picture>& shown) {
    AdaptiveAa all(context_.device(), lit(), camera_, params(kFigureWindow, "ssaa"));
    all.execute();
    const Image reference = all.picture();
    shown["reference"] = to_picture(reference);
    std::vector<Row> rows;
    for (const std::uint32_t anisotropy : {16u, 1u}) {
        AdaptiveAaParams p = as_paper(kFigureWindow);
        p.anisotropy = anisotropy;
        AdaptiveAa aa(context_.device(), lit(), camera_, p);
        aa.execute();
        const std::string title = anisotropy == 1 ? "isotropic" : "anisotropic";
        shown[title] = to_picture(aa.picture());
        shown[title + "_error"] = error_picture(aa.picture(), reference);
        rows.push_back(
            {.knob = double(anisotropy), .values = errors_of(aa, kFigureWindow, reference)});
    }
    return rows;
}

/// One sample, FXAA, both terms, the geometric one, that of shading: against all 3 x 3 samples.
std::vector<Row> PaperAa::figure_8(std::map<std::string, Picture>& shown) {
    AdaptiveAa all(context_.device(), lit(), camera_, params(kFigureWindow, "ssaa"));
    all.execute();
    const Image reference = all.picture();
    shown["reference"] = to_picture(reference);
    AdaptiveAaParams geometry = as_paper(kFigureWindow), shading = geometry;
    geometry.metrics.shading_weight = 0;
    shading.metrics.depth_weight = shading.metrics.normal_weight = 0;
    const std::pair<const char*, AdaptiveAaParams> pictures[] = {{"one", params(1, "none")},
        {"fxaa", params(1, "fxaa")}, {"both", as_paper(kFigureWindow)}, {"geometry", geometry},
        {"shading", shading}};
    std::vector<Row> rows;
    for (const auto& [title, p] : pictures) {
        AdaptiveAa aa(context_.device(), lit(), camera_, p);
        aa.execute();
        const std::string prefix = title;
        shown[prefix] = to_picture(aa.picture());
        shown[prefix + "_error"] = error_picture(aa.picture(), reference);
        if (p.m > 1)
            shown[prefix + "_counts"] = count_picture(aa.read(aa.outputs().sample_count), p.m);
        Row row{.knob = double(rows.size()), .values = errors_of(aa, kFigureWindow, reference)};
        if (p.m == 1) row.values["samples_percent"] = 100.0 / (kFigureWindow * kFigureWindow);
        rows.push_back(std::move(row));
    }
    return rows;
}

/// Rows in the order of kDispatches, stencil left out where the device has none.
std::vector<Row> PaperAa::dispatches() {
    std::vector<std::unique_ptr<AdaptiveAa>> pictures;
    std::vector<Dispatch> kinds;
    for (const Dispatch dispatch : kDispatches) {
        if (dispatch == Dispatch::stencil && !context_.device().exports_stencil()) continue;
        AdaptiveAaParams p = as_paper(kFigureWindow);
        p.dispatch = dispatch;
        p.stall = kStall;
        kinds.push_back(dispatch);
        pictures.push_back(std::make_unique<AdaptiveAa>(context_.device(), lit(), camera_, p));
        pictures.back()->execute();
    }
    std::vector<std::vector<double>> times(pictures.size());
    for (int turn = 0; turn < 5; ++turn)
        for (std::size_t i = 0; i < pictures.size(); ++i) {
            pictures[i]->execute();
            times[i].push_back(milliseconds(pictures[i]->times(), is_shading_pass));
        }
    const double loop = spread(times.front()).median;
    std::vector<Row> rows;
    for (std::size_t i = 0; i < pictures.size(); ++i) {
        const double median = spread(times[i]).median;
        rows.push_back({.knob = double(kinds[i]),
            .values = {{"shading_gpu_ms", median}, {"over_loop", median / loop}}});
    }
    return rows;
}

namespace {

const Point* find(const std::vector<Point>& points, const std::string& series, double knob) {
    for (const Point& point : points)
        if (point.job->series == series && point.knob == knob) return &point;
    return nullptr;
}

/// (1 - time ratio) / (1 - sample ratio): the share of the saved samples that became saved time.
double captured(double time, double reference, double samples_percent) {
    return (1 - time / reference) / (1 - samples_percent / 100);
}

double value(const Point* point, const char* name) {
    return point == nullptr || !point->has(name) ? paper::kNotGiven : (*point)[name].median;
}

} // namespace

Table PaperAa::table_1(const std::vector<Point>& points) const {
    Table table{.name = "papers_aa_table_1",
        .title = "Table 1 of Holländer et al. 2013: the paper's numbers, and those of this machine",
        .columns = {"samples", "method", "ms/frame, paper", "here", "stalled ms, paper", "here",
            "MSE ×10⁻⁵, paper", "here", "dB as printed (peak 255), paper", "here",
            "dB (peak 1), paper", "here", "samples %, paper", "here", "captured, paper", "here",
            "captured stalled, paper", "here"},
        .rows = {},
        .caption =
            "Paper: Sponza of 280 K triangles at 1024 × 768 on a GeForce GTX 480. Here: " +
            fmt::format("<code>{}</code> at {} × {} on the device of this page; {} dependent "
                        "multiply-adds stall each sample, the paper does not say how many do. ",
                escape(scene_), width_, height_, kStall) +
            "Its dB column is its MSE with a peak of 255: 48.13 dB more than with a peak of 1. "
            "Captured: (1 − time ratio) / (1 − sample ratio), of whole frames. “as the paper” is "
            "<code>--preset paper</code>, “default” what this program does unasked; the paper "
            "gives "
            "none of its constants."};
    const char* const kRows[2][3] = {
        {"one sample", "FXAA", nullptr}, {"all samples", "as the paper", "default"}};
    for (const std::uint32_t m : {1u, 2u, 3u, 4u}) {
        const Point* reference = find(points, window_series(m), 0);
        const Point* stalled_reference = find(points, window_series(m, kStall), 0);
        for (int i = 0; i < (m == 1 ? 2 : 3); ++i) {
            const Point* here = find(points, window_series(m), i);
            const Point* stalled = find(points, window_series(m, kStall), i);
            paper::AaRow known{m, "", paper::kNotGiven, paper::kNotGiven, paper::kNotGiven,
                paper::kNotGiven, paper::kNotGiven};
            double full = paper::kNotGiven, full_stalled = paper::kNotGiven;
            int row = 0;
            for (const paper::AaRow& one : paper::kAaTable) {
                if (one.m != m) continue;
                if (row == 0) full = one.ms, full_stalled = one.stalled_ms;
                if (row++ == i) known = one;
            }
            const bool adaptive = m > 1 && i > 0;
            std::vector<std::string> cells{fmt::format("{0} × {0}", m), kRows[m > 1][i],
                cell(known.ms), cell(here, "total_gpu_ms", "{:.1f}"), cell(known.stalled_ms),
                cell(stalled, "total_gpu_ms", "{:.1f}")};
            if (!adaptive) {
                cells.resize(12);
                cells.push_back(m > 1 ? "100" : "");
                cells.push_back(m > 1 ? "100" : "");
                cells.resize(table.columns.size());
            } else {
                const double decibels = value(here, "psnr"),
                             percent = value(here, "samples_percent");
                for (const std::string& text : {cell(known.mse_1e5), cell(here, "mse_1e5"),
                         cell(known.psnr_255), cell(decibels + paper::kDecibelsOf255),
                         cell(known.psnr_255 - paper::kDecibelsOf255), cell(decibels),
                         cell(known.samples_percent, "{:.1f}"), cell(percent, "{:.1f}"),
                         cell(captured(known.ms, full, known.samples_percent)),
                         cell(captured(value(here, "total_gpu_ms"),
                             value(reference, "total_gpu_ms"), percent)),
                         cell(captured(known.stalled_ms, full_stalled, known.samples_percent)),
                         cell(captured(value(stalled, "total_gpu_ms"),
                             value(stalled_reference, "total_gpu_ms"), percent))})
                    cells.push_back(text);
            }
            table.rows.push_back(std::move(cells));
        }
    }
    return table;
}

Table PaperAa::figure_table(const std::vector<Point>& points) const {
    Table table{.name = "papers_aa_figures",
        .title = "Figures 5 and 8, and section 4.2, of Holländer et al. 2013, in numbers",
        .columns = {"of", "picture", "samples %", "MSE ×10⁻⁵", "dB (peak 1)", "SSIM", "mean FLIP",
            "time over a loop's, paper", "here"},
        .rows = {},
        .caption = "3 × 3, against all nine samples with anisotropic lookups. The paper prints no "
                   "numbers with its figures. Dispatch: shading passes, stalled, medians of five "
                   "turns."};
    const auto add = [&](const char* of, const char* title, const std::string& series,
                         double knob) {
        const Point* p = find(points, series, knob);
        table.rows.push_back({of, title, cell(p, "samples_percent", "{:.1f}"), cell(p, "mse_1e5"),
            cell(p, "psnr"), cell(p, "ssim", "{:.4f}"), cell(p, "flip", "{:.4f}"), "", ""});
    };
    add("figure 5", "adaptive, anisotropic lookups", "figure 5", 16);
    add("figure 5", "adaptive, isotropic lookups", "figure 5", 1);
    const char* const kPictures[] = {"one sample", "one sample, FXAA", "adaptive, both terms",
        "geometric term alone", "shading term alone"};
    for (int i = 0; i < 5; ++i) add("figure 8", kPictures[i], "figure 8", i);
    for (const Dispatch dispatch : kDispatches) {
        const Point* p = find(points, "dispatch", double(dispatch));
        if (p == nullptr) continue;
        const double known = dispatch == Dispatch::loop    ? 1.0
                             : dispatch == Dispatch::depth ? paper::kDepthDispatch
                             : dispatch == Dispatch::sort  ? paper::kSortDispatch
                                                           : paper::kNotGiven;
        table.rows.push_back({"section 4.2", std::string("dispatch: ") + name_of(dispatch), "", "",
            "", "", "", cell(known, "{:.1f}"), cell(p, "over_loop")});
    }
    return table;
}

Wipe PaperAa::wipe(const Store& store, const std::string& series, const std::string& title,
    const std::vector<std::pair<std::string, std::string>>& sides,
    const std::string& caption) const {
    Wipe wipe{.title = title, .sides = {}, .caption = caption};
    for (const Job& one : jobs_) {
        if (one.series != series || store.repeats(one).empty()) continue;
        const auto& pictures = store.repeats(one).front().pictures;
        const auto reference = pictures.find("reference");
        for (const auto& [label, name] : sides) {
            const auto picture = pictures.find(name), error = pictures.find(name + "_error");
            if (picture == pictures.end()) continue;
            wipe.sides.push_back({label, picture->second, {}});
            if (error == pictures.end()) continue;
            wipe.sides.back().error_map = error->second;
            wipe.sides.back().reference = reference->second;
        }
    }
    return wipe;
}

void PaperAa::report(const Store& store, const std::vector<Point>& points, Section& section) const {
    section.tables.push_back(table_1(points));
    section.tables.push_back(figure_table(points));
    section.wipes.push_back(wipe(store, "figure 5", "Figure 5: lookups, 3 × 3",
        {{"all samples, anisotropic", "reference"}, {"adaptive, isotropic", "isotropic"},
            {"adaptive, anisotropic", "anisotropic"}},
        "Error maps: largest difference of R, G, B from all samples, ten times."));
    for (const std::uint32_t m : {2u, 3u, 4u}) {
        section.wipes.push_back(wipe(store, window_series(m), fmt::format("Figure 7: {0} × {0}", m),
            {{"all samples", "reference"}, {"one sample", "one"}, {"as the paper", "paper"},
                {"samples, as the paper", "paper_counts"}, {"default", "ockham"},
                {"samples, default", "ockham_counts"}},
            fmt::format("Sample counts: dark for 1, pale yellow for {}.", m * m)));
    }
    section.wipes.push_back(wipe(store, "figure 8", "Figure 8: both terms, 3 × 3",
        {{"all samples", "reference"}, {"one sample", "one"}, {"FXAA", "fxaa"},
            {"both terms", "both"}, {"samples, both", "both_counts"},
            {"geometric term", "geometry"}, {"samples, geometric", "geometry_counts"},
            {"shading term", "shading"}, {"samples, shading", "shading_counts"}},
        "Small geometry is missed by the shading term and found by the geometric one."));
}

} // namespace ockham::chart

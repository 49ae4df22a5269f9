// SPDX-License-Identifier: Apache-2.0
// What is drawn of paper_volume.cpp's measurements.
#include "samples/chart/paper_numbers.hpp"
#include "samples/chart/paper_volume.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace ockham::chart {
namespace {

constexpr const char* kPsnr = "PSNR (dB, peak 1, displayed values)";

std::string cell(double number, const char* format = "{:.1f}") {
    return std::isnan(number) ? "" : fmt::format(fmt::runtime(format), number);
}
std::string cell(const Point& point, const char* value, const char* format = "{:.1f}") {
    return point.has(value) ? cell(point[value].median, format) : std::string();
}

} // namespace

std::vector<Plot> PaperVolume::convergence_plots(const std::vector<Point>& points) const {
    const std::string& scene = scenes_.front().name;
    std::vector<Plot> plots;
    for (const auto& [metric, label] :
        {std::pair<std::string, std::string>{"psnr", kPsnr}, {"ssim", "SSIM of luma"}}) {
        const Better better = Better::more;
        Plot figure_3{.name = "papers_volume_figure_3_" + metric,
            .question = "Figure 3: how fast do both variants converge? " + scene,
            .x = {"", "GPU time (s)", true, Better::less},
            .y = {"", label, false, better},
            .caption = "Each against the converged picture of mode noncaching with the same "
                       "shading. The paper's text has it so too; the caption of its figure says "
                       "“of the respective variant”. Caching shows the "
                       "mean of its newest samples alone, half of them or more, while its cache "
                       "is refined: its picture is one of few samples for long."};
        Plot figure_4{.name = "papers_volume_figure_4_" + metric,
            .question = "Figure 4: how alike are both variants after equal time? " + scene,
            .x = {"seconds", "GPU time (s)", true},
            .y = {metric + "_between", label, false, better},
            .caption = "Noise of both is in it."};
        for (const char* shading : kPaperShadings) {
            const std::string series = fmt::format("moments, {}", shading);
            for (const char* mode : {"noncaching", "caching"}) {
                figure_3.x.value = fmt::format("seconds_{}", mode);
                figure_3.y.value = fmt::format("{}_{}", metric, mode);
                figure_3.curves.push_back(
                    curve(points, scene, series, figure_3, fmt::format("{}, {}", mode, shading)));
            }
            figure_4.curves.push_back(curve(points, scene, series, figure_4, shading));
        }
        plots.push_back(std::move(figure_3));
        plots.push_back(std::move(figure_4));
    }
    return plots;
}

/// Of the first scene's first repeat, by name.
std::map<std::string, std::string> PaperVolume::pictures_of(
    const Store& store, const std::string& series) const {
    for (const Job& job : jobs_)
        if (job.scene == scenes_.front().name && job.series == series &&
            !store.repeats(job).empty())
            return store.repeats(job).front().pictures;
    return {};
}

/// Figures 3 and 4 once more by each metric of another program, of the first repeat's pictures.
std::vector<Plot> PaperVolume::metric_plots(
    const Store& store, const std::vector<Point>& points) const {
    const std::string& scene = scenes_.front().name;
    std::vector<Plot> plots;
    for (const PictureMetrics::Metric& metric : context_.metrics().all()) {
        Plot figure_3{.name = "papers_volume_figure_3_" + metric.name,
            .question = "Figure 3 by another metric: " + scene,
            .x = {"gpu_seconds", "GPU time (s)", true, Better::less},
            .y = {metric.name, metric.title, false, metric.better},
            .caption = "The first repeat's pictures against the converged one of mode noncaching."};
        Plot figure_4{.name = "papers_volume_figure_4_" + metric.name,
            .question = "Figure 4 by another metric: " + scene,
            .x = {"gpu_seconds", "GPU time (s)", true},
            .y = {metric.name, metric.title, false, metric.better},
            .caption = "Both variants after equal time. Noise of both is in it."};
        for (const char* shading : kPaperShadings) {
            const auto pictures = pictures_of(store, fmt::format("moments, {}", shading));
            const auto converged = pictures_of(store, fmt::format("converged, {}", shading));
            Curve caching{.legend = fmt::format("caching, {}", shading)},
                noncaching{.legend = fmt::format("noncaching, {}", shading)},
                between{.legend = shading};
            const auto add = [&](Curve& to, double seconds, const std::string& test,
                                 const std::string& reference) {
                if (test.empty() || reference.empty()) return;
                if (const auto value = context_.metrics().of(metric, test, reference))
                    to.points.push_back({.x = {seconds, seconds, seconds},
                        .y = {*value, *value, *value},
                        .x_values = {seconds},
                        .y_values = {*value}});
            };
            const auto picture = [](const std::map<std::string, std::string>& from,
                                     const std::string& name) {
                const auto found = from.find(name);
                return found == from.end() ? std::string() : found->second;
            };
            for (const Point& point : points) {
                if (point.job->series != fmt::format("moments, {}", shading)) continue;
                const auto first = [&](const char* value) {
                    return point.values.at(value).front();
                };
                const std::string with = picture(pictures, fmt::format("caching_{}", point.knob)),
                                  without =
                                      picture(pictures, fmt::format("noncaching_{}", point.knob)),
                                  truth = picture(converged, "noncaching");
                add(noncaching, first("seconds_noncaching"), without, truth);
                add(caching, first("seconds_caching"), with, truth);
                add(between, first("seconds"), with, without);
            }
            figure_3.curves.push_back(std::move(noncaching));
            figure_3.curves.push_back(std::move(caching));
            figure_4.curves.push_back(std::move(between));
        }
        plots.push_back(std::move(figure_3));
        plots.push_back(std::move(figure_4));
    }
    return plots;
}

Table PaperVolume::cache_table(const std::vector<Point>& points) const {
    Table table{.name = "papers_volume_table_1",
        .title = "Table 1 of Šmajdek et al. 2023: smaller and less exact caches",
        .columns = {"voxels along a cell, floats", "PSNR dB, paper: backpack", "paper: wrasse"},
        .rows = {},
        .caption = fmt::format(
            "Against the picture from a cache with a cell for each voxel in 32-bit floats. Paper: "
            "512 × 280 × 374 and 198 × 470 × 432 voxels, 1024 × 1024 pixels. Here: composed "
            "pictures of {0} × {0} pixels, caches refined to an error of {1} or for {2} s, of one "
            "seed: those "
            "of one scale differ by rounding alone, others by noise too. Bytes are all that the "
            "cache takes while it is refined.",
            side_, params(VolumeMode::caching).cache_error, 5 * seconds_)};
    std::vector<std::string> scenes;
    for (const Point& point : points)
        if (point.job->series == "table 1" &&
            std::find(scenes.begin(), scenes.end(), point.job->scene) == scenes.end())
            scenes.push_back(point.job->scene);
    for (const std::string& scene : scenes) table.columns.push_back("here: " + scene);
    for (const char* title : {"SSIM, paper: backpack", "paper: wrasse"})
        table.columns.emplace_back(title);
    for (const std::string& scene : scenes) table.columns.push_back("here: " + scene);
    for (const std::string& scene : scenes) table.columns.push_back("bytes per voxel: " + scene);
    for (std::size_t i = 0; i < std::size(kCaches); ++i) {
        const CacheKind& kind = kCaches[i];
        const auto known = [&](const char* volume, double paper::CacheRow::*value) {
            const unsigned bits = kind.format == CacheFormat::fp32   ? 32
                                  : kind.format == CacheFormat::fp16 ? 16
                                                                     : 9;
            for (const paper::CacheRow& row : paper::kCacheTable)
                if (std::string(row.volume).starts_with(volume) && row.scale == kind.scale &&
                    row.bits == bits)
                    return row.*value;
            return paper::kNotGiven;
        };
        const auto here = [&](const std::string& scene, const char* value, const char* format) {
            for (const Point& point : points)
                if (point.job->series == "table 1" && point.job->scene == scene &&
                    point.knob == double(i))
                    return cell(point, value, format);
            return std::string();
        };
        std::vector<std::string> cells{kind.title,
            cell(known("Backpack", &paper::CacheRow::psnr), "{:.2f}"),
            cell(known("Wrasse", &paper::CacheRow::psnr), "{:.2f}")};
        for (const std::string& scene : scenes)
            cells.push_back(i == 0 ? "∞" : here(scene, "psnr", "{:.2f}"));
        cells.push_back(cell(known("Backpack", &paper::CacheRow::ssim), "{:.3f}"));
        cells.push_back(cell(known("Wrasse", &paper::CacheRow::ssim), "{:.3f}"));
        for (const std::string& scene : scenes) cells.push_back(here(scene, "ssim", "{:.4f}"));
        for (const std::string& scene : scenes)
            cells.push_back(here(scene, "bytes_per_voxel", "{:.1f}"));
        table.rows.push_back(std::move(cells));
    }
    return table;
}

Table PaperVolume::speed_table(const std::vector<Point>& points) const {
    Table table{.name = "papers_volume_frames",
        .title = "Frame rates of Šmajdek et al. 2023",
        .columns = {"what", "frames per second, paper", "here", "ms per frame, here",
            "million pixels per second, paper", "here"},
        .rows = {},
        .caption = fmt::format(
            "One sample per pixel, the camera moved before each frame; median of nine. Paper: 1024 "
            "× 1024 on an Nvidia Titan Xp. Here: {0} × {0} on the device of this page, "
            "<code>{1}</code>, composed.",
            frame_side_, escape(scenes_.front().flags()))};
    const char* const kTitles[] = {
        "path", "noncaching", "caching, refining the cache", "caching, cache at rest"};
    const char* const kRates[] = {
        "", paper::kFrameRate, paper::kFrameRate, paper::kSuspendedFrameRate};
    const char* const kPixels[] = {"", "10 to 31", "10 to 31", "up to 105"};
    for (const Point& point : points) {
        if (point.job->series != "frame rates") continue;
        const auto i = std::min(static_cast<std::size_t>(point.knob), std::size_t{3});
        table.rows.push_back({kTitles[i], kRates[i], cell(point, "frames_per_second"),
            cell(point, "frame_ms"), kPixels[i], cell(point, "mpixels_per_second", "{:.2f}")});
    }
    return table;
}

Table PaperVolume::memory_table(const std::vector<Point>& points) const {
    Table table{.name = "papers_volume_memory",
        .title = "Memory of Šmajdek et al. 2023",
        .columns = {"what", "floats, paper", "bytes, paper", "bytes, here"},
        .rows = {},
        .caption =
            "Per pixel: what a larger picture takes more, by the pixel. Per voxel: all that "
            "the cache takes while it is refined, its working set included, over all voxels, "
            "the empty ones too; small volumes bear parts of fixed size. The paper's 1440³ voxels "
            "in "
            "80 GB leave 27 bytes for each, "
            "half of its 14 floats."};
    const auto row = [&](const char* what, double floats, const std::string& here) {
        table.rows.push_back({what, cell(floats, "{:.0f}"), cell(4 * floats, "{:.0f}"), here});
    };
    for (const Point& point : points) {
        if (point.job->series != "memory") continue;
        const std::string pixel = cell(point, "bytes_per_pixel");
        if (point.knob == 0) row("path, per pixel", paper::kPathFloatsPerPixel, pixel);
        if (point.knob == 1) row("noncaching, per pixel", paper::kNoncachingFloatsPerPixel, pixel);
        if (point.knob != 2) continue;
        row("caching, composed, per pixel", paper::kNotGiven, pixel);
        row("caching, per voxel: a cell each, 32-bit", paper::kCachingFloatsPerVoxel,
            cell(point, "full_bytes_per_voxel"));
        row("caching, per voxel: default", paper::kCachingFloatsPerVoxel,
            cell(point, "bytes_per_voxel"));
    }
    return table;
}

Table PaperVolume::picture_table(const std::vector<Point>& points) const {
    Table table{.name = "papers_volume_figures",
        .title = "Figures 5, 6, 8 and 9 of Šmajdek et al. 2023, in numbers",
        .columns = {"scene", "shading", "caching composed and noncaching (dB)", "SSIM",
            "caching gathered and noncaching (dB)", "SSIM", "path and noncaching (dB)",
            "path and caching composed (dB)"},
        .rows = {},
        .caption = "Converged pictures, PSNR of displayed values with peak 1. The paper prints no "
                   "numbers with these figures. Its path tracing shows an opaque medium where it "
                   "has a surface; here the surface scatters."};
    for (const Point& point : points) {
        if (!point.job->series.starts_with("converged, ")) continue;
        table.rows.push_back({point.job->scene, point.job->series.substr(11),
            cell(point, "psnr_composed"), cell(point, "ssim_composed", "{:.4f}"),
            cell(point, "psnr_gathered"), cell(point, "ssim_gathered", "{:.4f}"),
            cell(point, "psnr_noncaching_path"), cell(point, "psnr_composed_path")});
    }
    return table;
}

void PaperVolume::add_wipes(const Store& store, Section& section) const {
    const auto side = [](const std::map<std::string, std::string>& pictures,
                          const std::string& name, const std::string& label, Wipe& wipe) {
        const auto picture = pictures.find(name), error = pictures.find(name + "_error");
        if (picture != pictures.end())
            wipe.sides.push_back(
                {label, picture->second, error == pictures.end() ? std::string() : error->second});
    };
    for (const Job& job : jobs_) {
        if (store.repeats(job).empty()) continue;
        const auto& pictures = store.repeats(job).front().pictures;
        if (job.series.starts_with("converged, ")) {
            Wipe wipe{.title = fmt::format(
                          "Figures 5, 6, 8 and 9: {}, {}", job.scene, job.series.substr(11)),
                .sides = {},
                .caption = "Error maps: caching against noncaching, and this against path, four "
                           "times."};
            side(pictures, "noncaching", "noncaching", wipe);
            side(pictures, "composed", "caching, composed", wipe);
            side(pictures, "gathered", "caching, gathered", wipe);
            side(pictures, "path", "path", wipe);
            for (std::size_t i = 1; i + 1 < wipe.sides.size(); ++i)
                wipe.sides[i].reference = wipe.sides[0].picture;
            section.wipes.push_back(std::move(wipe));
        } else if (job.series == "moments, lambert") {
            for (std::size_t mode = 0; mode < 3; ++mode) {
                const std::string name = name_of(static_cast<VolumeMode>(mode));
                Wipe wipe{.title = "Figure 7: " + name + ", as time goes on",
                    .sides = {},
                    .caption = fmt::format(
                        "The paper's 0.5 to 30 s, times {:.3g}. Error maps: against the converged "
                        "picture, ten times.",
                        seconds_ / paper::kAllSeconds)};
                for (const double moment : paper::kMoments)
                    side(pictures, fmt::format("{}_{}", name, moment),
                        fmt::format("{:.3g} s", moment / paper::kAllSeconds * seconds_), wipe);
                const auto converged = pictures_of(store, "converged, lambert");
                const auto reference = converged.find(mode == 0 ? "path" : "noncaching");
                if (reference != converged.end())
                    for (Wipe::Side& one : wipe.sides) one.reference = reference->second;
                section.wipes.push_back(std::move(wipe));
            }
        }
    }
}

void PaperVolume::report(
    const Store& store, const std::vector<Point>& points, Section& section) const {
    for (Plot& plot : convergence_plots(points)) section.plots.push_back(std::move(plot));
    for (Plot& plot : metric_plots(store, points)) section.plots.push_back(std::move(plot));
    section.tables.push_back(cache_table(points));
    section.tables.push_back(picture_table(points));
    section.tables.push_back(speed_table(points));
    section.tables.push_back(memory_table(points));
    add_wipes(store, section);
}

} // namespace ockham::chart

// SPDX-License-Identifier: Apache-2.0
#include "samples/chart/volume_suite.hpp"

#include "framework/core/file.hpp"
#include "framework/image_error/image_error.hpp"
#include "samples/chart/surface_search.hpp"
#include "samples/chart/volume_prediction.hpp"
#include "samples/chart/volume_runs.hpp"

#include <fmt/format.h>

#include <cmath>

namespace ockham::chart {
namespace {

constexpr const char* kShadings[] = {"lambert", "phong", "disney"};
constexpr CacheFormat kFormats[] = {CacheFormat::fp32, CacheFormat::fp16, CacheFormat::rgb9e5};

const char* name_of(CacheFormat format) {
    return format == CacheFormat::fp32 ? "fp32" : format == CacheFormat::fp16 ? "fp16" : "rgb9e5";
}

constexpr Axis kSeconds{"gpu_seconds", "GPU time (s)", true, Better::less};
constexpr const char* kPsnr = "PSNR (dB, peak 1, displayed values)";

class VolumeSuite : public Suite {
public:
    explicit VolumeSuite(Context& context);
    std::string name() const override { return "volume"; }
    std::vector<Job> jobs() override { return list_.jobs(); }
    std::unique_ptr<Subject> open(const Job& job) override { return list_.open(job); }
    Section report(const Store& store, const std::vector<Point>& points) override;

private:
    VolumeGiParams params(const VolumeTechnique& technique) const;
    Job job(const VolumeScene& scene, const std::string& series, const std::string& flags) const;
    void add_run(const VolumeScene& scene, const std::string& series, const std::string& flags,
        const VolumeGiParams& params, bool in_class = false);
    void add_reference(const VolumeScene& scene, VolumeMode mode);
    void add_modes(const VolumeScene& scene);
    void add_shadings(const VolumeScene& scene);
    void add_estimators(const VolumeScene& scene);
    void add_caches(const VolumeScene& scene);
    void add_searches();
    Plot time_plot(const std::vector<Point>& points, const VolumeScene& scene,
        const std::string& stem, const std::string& question, Axis y,
        const std::vector<std::string>& series) const;
    Plot cache_plot(const std::vector<Point>& points, const VolumeScene& scene) const;
    std::vector<Plot> search_plots(const std::vector<Point>& points) const;
    Table reference_table(const std::vector<Point>& points) const;
    Wipe wipe(const Store& store, const VolumeScene& scene) const;

    Context& context_;
    std::uint32_t side_;
    double seconds_; ///< of a run
    std::vector<VolumeScene> scenes_;
    std::vector<VolumeScene> classes_;         ///< those, and others that choices are made by
    std::optional<VolumeScene> surface_scene_; ///< the first that has an isosurface
    VolumeScene estimator_scene_, search_scene_;
    VolumeReferences references_;
    JobList list_;
};

VolumeSuite::VolumeSuite(Context& context)
    : context_(context), side_(context.options.quick ? 64 : 160),
      seconds_(context.options.quick ? 0.8 : 12), scenes_(volume_scenes(context.options)),
      classes_(class_scenes(context.options)), references_(context, side_) {
    for (const VolumeScene& scene : scenes_)
        if (!surface_scene_ && !scene.options.iso.empty()) surface_scene_ = scene;
    estimator_scene_ = scenes_.front();
    estimator_scene_.name += ", sky";
    estimator_scene_.sky = true;
    estimator_scene_.options.light.clear();
    estimator_scene_.options.iso.clear();
    search_scene_.name = "shells";
    search_scene_.options.volume = {context.options.quick ? "builtin:shells:64" : "builtin:shells"};
    search_scene_.options.iso = "100";
    search_scene_.options.transfer = "smoke";

    for (const VolumeScene& scene : classes_) add_modes(scene);
    if (surface_scene_) add_shadings(*surface_scene_);
    add_estimators(estimator_scene_);
    for (const VolumeScene& scene : scenes_) add_caches(scene);
    add_searches();
}

VolumeGiParams VolumeSuite::params(const VolumeTechnique& technique) const {
    VolumeGiParams p;
    p.width = p.height = side_;
    p.mode = technique.mode;
    p.gather = technique.gather;
    p.cache_error = 0.05f;
    return p;
}

Job VolumeSuite::job(
    const VolumeScene& scene, const std::string& series, const std::string& flags) const {
    return {.suite = name(),
        .scene = scene.name,
        .series = series,
        .setting = {},
        .inputs = fmt::format(
            "{} {} {} {} {}", scene.inputs(), flags, side_, seconds_, context_.device_text()),
        .command = fmt::format(
            "volume_gi {} {} --width {} --height {}", scene.flags(), flags, side_, side_)};
}

void VolumeSuite::add_run(const VolumeScene& scene, const std::string& series,
    const std::string& flags, const VolumeGiParams& params, bool in_class) {
    // With surfaces, path has another transport than the other two.
    const VolumeMode mode =
        params.mode == VolumeMode::path ? VolumeMode::path : VolumeMode::noncaching;
    list_.add(job(scene, series, flags), [this, scene, params, mode, in_class] {
        const VolumeReference& reference = references_.of(scene, mode);
        return std::make_unique<VolumeRun>(context_.device(), scene, params, reference, seconds_,
            in_class ? &references_.of(scene, VolumeMode::path) : nullptr);
    });
}

void VolumeSuite::add_reference(const VolumeScene& scene, VolumeMode mode) {
    Job once = job(scene, fmt::format("reference, {}", ockham::name_of(mode)),
        fmt::format("--mode {} --sampler independent", ockham::name_of(mode)));
    if (!scene.options.iso.empty()) once.series += ", " + scene.options.shading;
    once.repeats = 1;
    list_.add(once, [this, scene, mode] {
        return std::make_unique<Once>([this, scene, mode](std::map<std::string, Picture>& shown) {
            const VolumeReference& reference = references_.of(scene, mode);
            shown["picture"] = to_picture(reference.picture);
            return std::vector<Row>{{.knob = reference.samples,
                .values = {{"samples", reference.samples},
                    {"psnr", -10 * std::log10(std::max(reference.mse, 1e-99))},
                    {"relrmse", std::sqrt(reference.relmse)}, {"relmse", reference.relmse}}}};
        });
    });
}

void VolumeSuite::add_modes(const VolumeScene& scene) {
    add_reference(scene, VolumeMode::path);
    if (!scene.options.iso.empty()) add_reference(scene, VolumeMode::noncaching);
    for (const VolumeTechnique& technique : kVolumeTechniques) {
        std::string flags = fmt::format("--mode {}", ockham::name_of(technique.mode));
        if (technique.mode == VolumeMode::caching)
            flags += technique.gather ? " --gather on" : " --gather off";
        add_run(scene, name_of(technique), flags, params(technique), true);
    }
}

void VolumeSuite::add_shadings(const VolumeScene& scene) {
    for (const char* shading : kShadings) {
        if (scene.options.shading == shading) continue; // add_modes() has it
        const VolumeScene shaded = scene.with_shading(shading);
        add_reference(shaded, VolumeMode::noncaching);
        for (const VolumeTechnique& technique : {kVolumeTechniques[1], kVolumeTechniques[2]}) {
            add_run(shaded, fmt::format("{}, {}", ockham::name_of(technique.mode), shading),
                fmt::format("--mode {}", ockham::name_of(technique.mode)), params(technique));
        }
    }
}

void VolumeSuite::add_estimators(const VolumeScene& scene) {
    add_reference(scene, VolumeMode::path);
    for (const bool grid : {true, false})
        for (const bool nee : {true, false}) {
            VolumeGiParams p = params(kVolumeTechniques[0]);
            p.majorant_grid = grid;
            p.nee = nee;
            add_run(scene,
                fmt::format("{}, {}", grid ? "grid" : "global", nee ? "sampled" : "by chance"),
                fmt::format("--mode path --majorant {} --nee {}", grid ? "grid" : "global",
                    nee ? "on" : "off"),
                p);
        }
}

/// Every format at the default size of cells, and every size in the default format; all of them
/// where there is time. What is composed shows the cache's own error.
void VolumeSuite::add_caches(const VolumeScene& scene) {
    for (const CacheFormat format : kFormats)
        for (const std::uint32_t scale : {4u, 2u, 1u}) {
            const bool quick = context_.options.quick;
            if (quick && (scale == 1 || (scale != 2 && format != CacheFormat::fp16))) continue;
            if (quick && &scene != &scenes_.back()) continue;
            VolumeGiParams p = params(kVolumeTechniques[3]);
            p.cache_format = format;
            p.cache_scale = scale;
            p.cache_error = quick ? 0.2f : 0.05f;
            Job once = job(scene, fmt::format("cache, {}", name_of(format)),
                fmt::format("--mode caching --gather off --cache-format {} --cache-scale {} "
                            "--target-error {}",
                    name_of(format), scale, p.cache_error));
            once.setting = fmt::format("cells of {0} x {0} x {0} voxels", scale);
            once.repeats = 1;
            list_.add(once, [this, scene, p, scale] {
                return std::make_unique<Once>([this, scene, p, scale](auto& shown) {
                    const VolumeSource source = scene.load();
                    VolumeGi gi(context_.device(), source.volume, source.transfer,
                        source.environment, source.view, scene.view(), p);
                    const double gpu =
                        converge(gi, context_.options.quick ? 120 : 4000, 5 * seconds_);
                    for (int step = 0; step < 16 && !interrupted(); ++step) gi.execute();
                    gi.finish();
                    const Image picture = gi.picture();
                    const VolumeReference& reference =
                        references_.of(scene, VolumeMode::noncaching);
                    const ImageError error = image_error(picture, reference.picture);
                    shown["picture"] = to_picture(picture);
                    shown["error"] = error_picture(picture, reference.picture);
                    const VolumeStatistics now = gi.statistics();
                    const auto bytes = static_cast<double>(now.cell_bytes);
                    return std::vector<Row>{{.knob = static_cast<double>(scale),
                        .values = {{"cell_mib", bytes / (1 << 20)},
                            {"bytes_per_voxel",
                                bytes / static_cast<double>(source.volume.voxel_count())},
                            {"cells", static_cast<double>(now.cells)}, {"psnr", error.psnr},
                            {"ssim", error.ssim}, {"flip", error.flip.mean},
                            {"relmse", error.relmse}, {"gpu_seconds", gpu},
                            {"converged", now.cache_converged ? 1.0 : 0.0}}}};
                });
            });
        }
}

void VolumeSuite::add_searches() {
    const std::pair<const char*, SurfaceSearch> searches[] = {{"exact", SurfaceSearch::exact},
        {"march", SurfaceSearch::march}, {"stochastic", SurfaceSearch::stochastic}};
    for (const auto& [title, search] : searches) {
        list_.add(job(search_scene_, title,
                      fmt::format("--mode caching --gather off --surface-search {}", title)),
            [this, which = search] {
                const std::uint32_t most = context_.options.quick ? 256 : 2048;
                return std::make_unique<SurfaceSearchRun>(
                    context_.device(), search_scene_, which, side_, most);
            });
    }
}

Plot VolumeSuite::time_plot(const std::vector<Point>& points, const VolumeScene& scene,
    const std::string& stem, const std::string& question, Axis y,
    const std::vector<std::string>& series) const {
    Plot plot{.name = stem, .question = question, .x = kSeconds, .y = std::move(y)};
    for (const std::string& one : series)
        plot.curves.push_back(curve(points, scene.name, one, plot, one));
    return plot;
}

Plot VolumeSuite::cache_plot(const std::vector<Point>& points, const VolumeScene& scene) const {
    Plot plot{.name = "volume_cache_" + stem_of(scene.name),
        .question = "What do the bytes of a cache buy? " + scene.name,
        .x = {"cell_mib", "cache (MiB)", true, Better::less},
        .y = {"psnr", kPsnr, false, Better::more},
        .caption = "Composed from a cache that has reached its error (<code>--target-error</code>) "
                   "against the reference of mode noncaching; where its time was over first, a dot "
                   "says so, and more time would give more. Along a curve the cells shrink. "
                   "Bytes are all that the cache takes while it is refined."};
    std::vector<Point> unfinished;
    for (const CacheFormat format : kFormats) {
        const std::string series = fmt::format("cache, {}", name_of(format));
        plot.curves.push_back(curve(points, scene.name, series, plot, name_of(format)));
    }
    for (const Point& point : points) {
        if (!point.has("converged") || point["converged"].median > 0) continue;
        unfinished.push_back(point);
    }
    Curve stopped{.legend = "stopped by its time", .kind = Curve::Kind::dots, .competes = false};
    for (const CacheFormat format : kFormats)
        for (PlotPoint& point :
            curve(unfinished, scene.name, fmt::format("cache, {}", name_of(format)), plot, "")
                .points)
            stopped.points.push_back(std::move(point));
    plot.curves.push_back(std::move(stopped));
    std::erase_if(plot.curves, [](const Curve& one) { return one.points.empty(); });
    return plot;
}

std::vector<Plot> VolumeSuite::search_plots(const std::vector<Point>& points) const {
    const Axis cost{"gpu_ms", "GPU time (ms)", true, Better::less};
    Plot wrong{.name = "volume_search_wrong",
        .question = "How many pixels see a wrong surface?",
        .x = cost,
        .y = {"wrong_percent", "pixels off by more than a voxel (%)", false, Better::less},
        .caption =
            "Eight thin shells, the outermost a voxel thick. Beside a march of 1/16 voxel in "
            "double precision. stochastic: Algorithm 1 after 1, 2, 4 … candidates per "
            "pixel, executed one by one; march: 16, 32 … steps per ray, then bisection."};
    Plot error{.name = "volume_search_error",
        .question = "How exact are the surfaces that are found?",
        .x = cost,
        .y = {"error_voxels", "error of the right ones (voxels, rms)", true, Better::less},
        .caption = "Of pixels that are off by no more than a voxel."};
    for (Plot* plot : {&wrong, &error})
        for (const char* series : {"exact", "march", "stochastic"})
            plot->curves.push_back(curve(points, search_scene_.name, series, *plot, series));
    return {wrong, error};
}

Table VolumeSuite::reference_table(const std::vector<Point>& points) const {
    Table table{.name = "volume_references",
        .title = "References, and how far they are from what they converge to",
        .columns = {"scene", "reference", "samples per pixel", "PSNR (dB)", "relMSE"},
        .rows = {},
        .caption = "From two halves with samples of their own: a quarter of what these differ by. "
                   "Curves bend where they come near to this error."};
    for (const Point& point : points) {
        if (!point.job->series.starts_with("reference")) continue;
        table.rows.push_back({point.job->scene, point.job->series.substr(11),
            fmt::format("{:.0f}", point.knob), fmt::format("{:.1f}", point["psnr"].median),
            fmt::format("{:.2g}", point["relmse"].median)});
    }
    return table;
}

Wipe VolumeSuite::wipe(const Store& store, const VolumeScene& scene) const {
    Wipe wipe{.title = scene.name,
        .sides = {},
        .caption = "The last picture of the first run of each technique. Error maps: largest "
                   "difference of R, G, B from the technique's reference, ten times, blue for 0."};
    for (const Job& job : list_.jobs()) {
        if (job.scene != scene.name || job.series.find("cache,") == 0) continue;
        const std::vector<Repeat>& repeats = store.repeats(job);
        if (repeats.empty() || !repeats.front().pictures.contains("picture")) continue;
        const auto& pictures = repeats.front().pictures;
        const auto error = pictures.find("error");
        wipe.sides.push_back({job.series, pictures.at("picture"),
            error == pictures.end() ? std::string() : error->second});
    }
    // As add_run() compares them.
    const auto picture_of = [&](const std::string& series) {
        for (const Wipe::Side& side : wipe.sides)
            if (side.label.starts_with(series)) return side.picture;
        return std::filesystem::path();
    };
    const std::filesystem::path path = picture_of("reference, path"),
                                local = picture_of("reference, noncaching");
    for (Wipe::Side& side : wipe.sides)
        if (!side.label.starts_with("reference") && side.label.find(", ") == std::string::npos)
            side.reference = side.label == "path" || local.empty() ? path : local;
    return wipe;
}

Section VolumeSuite::report(const Store& store, const std::vector<Point>& points) {
    Section section{.title = "Volumes",
        .text = fmt::format(
            "Pictures of {0} × {0} pixels. Each run begins anew with another seed, its error is "
            "measured after 1, 2, 4 … samples per pixel and until {1} s of GPU time are spent; "
            "times are sums of the passes' timestamps. Mode path shows light that surfaces "
            "reflect onto each other, the others do not: each is compared with a reference of its "
            "own transport.",
            side_, seconds_)};
    section.text +=
        " Caching begins its mean anew after 1, 2, 4 … steps while its cache is refined, "
        "so that light from a coarser one leaves the picture.";
    std::vector<std::string> modes;
    for (const VolumeTechnique& technique : kVolumeTechniques) modes.push_back(name_of(technique));
    for (const VolumeScene& scene : scenes_) {
        const std::string stem = stem_of(scene.name);
        section.plots.push_back(time_plot(points, scene, "volume_modes_psnr_" + stem,
            "Error against time, by mode: " + scene.name, {"psnr", kPsnr, false, Better::more},
            modes));
        section.plots.push_back(time_plot(points, scene, "volume_modes_flip_" + stem,
            "Visible difference against time, by mode: " + scene.name,
            {"flip", "mean FLIP", true, Better::less}, modes));
        section.plots.push_back(time_plot(points, scene, "volume_modes_relmse_" + stem,
            "Error of linear values against time, by mode: " + scene.name,
            {"relmse", "relMSE", true, Better::less}, modes));
    }
    if (surface_scene_) {
        std::vector<std::string> series{
            name_of(kVolumeTechniques[1]), name_of(kVolumeTechniques[2])};
        for (const char* shading : kShadings)
            if (surface_scene_->options.shading != shading)
                for (const VolumeTechnique& technique :
                    {kVolumeTechniques[1], kVolumeTechniques[2]})
                    series.push_back(
                        fmt::format("{}, {}", ockham::name_of(technique.mode), shading));
        Plot plot = time_plot(points, *surface_scene_, "volume_shading",
            "Does the shading model matter? " + surface_scene_->name,
            {"psnr", kPsnr, false, Better::more}, series);
        for (std::size_t i : {0u, 1u})
            plot.curves[i].legend = fmt::format("{}, {}",
                ockham::name_of(kVolumeTechniques[1 + i].mode), surface_scene_->options.shading);
        section.plots.push_back(std::move(plot));
    }
    Plot estimators = time_plot(points, estimator_scene_, "volume_estimators",
        "What do majorants and sampled light gain? " + estimator_scene_.name,
        {"relmse", "relMSE", true, Better::less},
        {"grid, sampled", "grid, by chance", "global, sampled", "global, by chance"});
    estimators.caption =
        "Majorants of a grid or one for all; light sampled at collisions or met "
        "by chance. Under a sky with a sun of 10 degrees: next-event estimation is for "
        "environment maps, the directional light is always sampled.";
    section.plots.push_back(std::move(estimators));
    for (const VolumeScene& scene : scenes_) {
        Plot plot = cache_plot(points, scene);
        if (!plot.curves.empty()) section.plots.push_back(std::move(plot));
    }
    const VolumeChart chart = volume_chart_of(points, classes_, context_.device_text());
    write_text(context_.options.out / "volume_chart.json", to_json(chart));
    for (Plot& plot : volume_prediction_plots(chart)) section.plots.push_back(std::move(plot));
    for (Plot& plot : search_plots(points)) section.plots.push_back(std::move(plot));
    section.tables.push_back(reference_table(points));
    for (const VolumeScene& scene : scenes_) section.wipes.push_back(wipe(store, scene));
    return section;
}

} // namespace

std::unique_ptr<Suite> make_volume_suite(Context& context) {
    return std::make_unique<VolumeSuite>(context);
}

} // namespace ockham::chart

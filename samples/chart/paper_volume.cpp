// SPDX-License-Identifier: Apache-2.0
#include "samples/chart/paper_volume.hpp"

#include "framework/image_error/image_error.hpp"
#include "passes/volume/frame.hpp"
#include "samples/chart/paper_numbers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace ockham::chart {
namespace {

/// `builtin:NAME:48` or, where there is time, as large as it comes.
VolumeScene builtin_scene(const ChartOptions& options, const std::string& name, const char* iso,
    float density, const char* side) {
    VolumeScene scene;
    scene.name = name;
    scene.options.volume = {"builtin:" + name + (options.quick ? side : "")};
    scene.options.transfer = "smoke";
    scene.options.iso = iso;
    scene.options.density_scale = density;
    scene.options.albedo = 0.9f;
    scene.options.light = "0.3,0.9,-0.5 3,2.8,2.5";
    scene.options.environment = "0.1,0.13,0.18";
    return scene;
}

std::vector<VolumeScene> paper_scenes(const ChartOptions& options, const char* side) {
    if (options.volumes.empty()) {
        return {builtin_scene(options, "fingers", "200", 20, side),
            builtin_scene(options, "cluster", "120", 40, side)};
    }
    std::vector<VolumeScene> scenes = volume_scenes(options);
    std::stable_partition(scenes.begin(), scenes.end(),
        [](const VolumeScene& scene) { return !scene.options.iso.empty(); });
    return scenes;
}

VolumeGi make_picture(gpu::Device& device, const VolumeScene& scene, const VolumeSource& source,
    const VolumeGiParams& params) {
    return {device, source.volume, source.transfer, source.environment, source.view, scene.view(),
        params};
}

} // namespace

/// Figures 3, 4 and 7: the three modes in turns, each stopped at the same moments of its own GPU
/// time. A row for each moment.
class PaperVolume::Moments : public Subject {
public:
    Moments(PaperVolume& owner, const VolumeScene& scene)
        : owner_(owner), scene_(scene), source_(scene.load()),
          seed_(source_.view.seed), references_{&owner.references_.of(scene, VolumeMode::path),
                                        &owner.references_.of(scene, VolumeMode::noncaching),
                                        &owner.references_.of(scene, VolumeMode::noncaching)} {
        for (const VolumeMode mode :
            {VolumeMode::path, VolumeMode::noncaching, VolumeMode::caching}) {
            pictures_.push_back(std::make_unique<VolumeGi>(owner.context_.device(), source_.volume,
                source_.transfer, source_.environment, source_.view, scene.view(),
                owner.params(mode)));
            pictures_.back()->execute();
            pictures_.back()->finish();
        }
    }

    std::vector<Row> measure() override {
        source_.view.seed = ++seed_;
        for (const auto& one : pictures_) one->set_view(source_.view);
        double taken[3] = {};
        std::vector<Row> rows;
        for (const double moment : paper::kMoments) {
            Image images[3];
            Row row{.knob = moment, .values = {}};
            for (std::size_t i = 0; i < 3; ++i) {
                const std::string mode = name_of(static_cast<VolumeMode>(i));
                while (taken[i] < moment / paper::kAllSeconds * owner_.seconds_) {
                    if (interrupted()) return rows;
                    pictures_[i]->execute();
                    taken[i] += gpu_seconds(pictures_[i]->executor());
                }
                for (; !pictures_[i]->finished(); pictures_[i]->drain()) {
                }
                images[i] = pictures_[i]->picture();
                const ImageError error = image_error(images[i], references_[i]->picture);
                row.values["seconds_" + mode] = taken[i];
                row.values["psnr_" + mode] = error.psnr;
                row.values["ssim_" + mode] = error.ssim;
                if (shown_.size() < 2 * 3 * std::size(paper::kMoments)) {
                    const std::string title = fmt::format("{}_{}", mode, moment);
                    shown_[title] = to_picture(images[i]);
                    shown_[title + "_error"] = error_picture(images[i], references_[i]->picture);
                }
            }
            const ImageError between = image_error(images[2], images[1]);
            row.values["seconds"] = std::max(taken[1], taken[2]);
            row.values["psnr_between"] = between.psnr;
            row.values["ssim_between"] = between.ssim;
            rows.push_back(std::move(row));
        }
        return rows;
    }
    std::map<std::string, Picture> pictures() override { return shown_; }

private:
    PaperVolume& owner_;
    VolumeScene scene_;
    VolumeSource source_;
    std::uint32_t seed_;
    const VolumeReference* references_[3];
    std::vector<std::unique_ptr<VolumeGi>> pictures_; ///< in the order of VolumeMode
    std::map<std::string, Picture> shown_;
};

PaperVolume::PaperVolume(Context& context, JobList& list)
    : context_(context), side_(context.options.quick ? 64 : 256),
      frame_side_(context.options.quick ? 256 : 1024), most_(context.options.quick ? 400 : 4000),
      seconds_(context.options.quick ? 1.5 : 30), scenes_(paper_scenes(context.options, ":40")),
      small_scenes_(paper_scenes(context.options, ":24")), references_(context, side_) {
    // A cell for each voxel of all of a scan would take half an hour.
    for (VolumeScene& scene : small_scenes_)
        if (!context.options.volumes.empty()) scene.options.crop = "0.4,0.6,0.4,0.6,0.4,0.6";
    const std::string caching = "--mode caching --gather off";
    for (const char* shading : kPaperShadings) {
        const VolumeScene scene = scenes_.front().with_shading(shading);
        add(
            scene, fmt::format("moments, {}", shading), caching,
            [this, scene] { return std::make_unique<Moments>(*this, scene); }, list);
    }
    const auto once = [this](const VolumeScene& scene, auto body) {
        return [this, scene, body] {
            return std::make_unique<Once>(
                [this, scene, body](auto& shown) { return (this->*body)(scene, shown); });
        };
    };
    for (const VolumeScene& scene : scenes_) {
        for (const char* shading : kPaperShadings) {
            if (&scene != &scenes_.front() && scene.options.shading != shading) continue;
            add(scene.with_shading(shading), fmt::format("converged, {}", shading), caching,
                once(scene.with_shading(shading), &PaperVolume::converged), list);
        }
    }
    const auto plain = [this](const VolumeScene& scene, auto body) {
        return [this, scene, body] {
            return std::make_unique<Once>(
                [this, scene, body](auto&) { return (this->*body)(scene); });
        };
    };
    for (std::size_t i = 0; i < std::min<std::size_t>(small_scenes_.size(), 2); ++i)
        add(small_scenes_[i], "table 1", caching + " --cache-scale 1 --cache-format fp32",
            plain(small_scenes_[i], &PaperVolume::caches), list);
    add(scenes_.front(), "frame rates", caching, plain(scenes_.front(), &PaperVolume::frame_rates),
        list);
    add(scenes_.front(), "memory", caching, plain(scenes_.front(), &PaperVolume::memory), list);
}

void PaperVolume::add(const VolumeScene& scene, const std::string& series, const std::string& flags,
    JobList::Open open, JobList& list) {
    Job job{.suite = "papers",
        .scene = scene.name,
        .series = series,
        .setting = {},
        .inputs = fmt::format(
            "{} {} {} {} {}", scene.inputs(), flags, side_, seconds_, context_.device_text()),
        .command = fmt::format(
            "volume_gi {} {} --width {} --height {}", scene.flags(), flags, side_, side_),
        .repeats = series == "moments, lambert" ? 0 : 1};
    jobs_.push_back(job);
    list.add(std::move(job), std::move(open));
}

/// As the paper: composed from the cache.
VolumeGiParams PaperVolume::params(VolumeMode mode) const {
    VolumeGiParams p;
    p.width = p.height = side_;
    p.mode = mode;
    p.gather = false;
    p.cache_error = context_.options.quick ? 0.2f : 0.03f;
    return p;
}

/// Figures 5, 6, 8 and 9.
std::vector<Row> PaperVolume::converged(
    const VolumeScene& scene, std::map<std::string, Picture>& shown) {
    const VolumeReference& path = references_.of(scene, VolumeMode::path);
    const VolumeReference& noncaching = references_.of(scene, VolumeMode::noncaching);
    shown["path"] = to_picture(path.picture);
    shown["noncaching"] = to_picture(noncaching.picture);
    shown["noncaching_error"] = error_picture(noncaching.picture, path.picture, 4);
    Row row{.knob = 0, .values = {}};
    const ImageError modes = image_error(noncaching.picture, path.picture);
    row.values = {{"psnr_noncaching_path", modes.psnr}, {"ssim_noncaching_path", modes.ssim}};
    const VolumeSource source = scene.load();
    for (const bool gather : {false, true}) {
        VolumeGiParams p = params(VolumeMode::caching);
        p.gather = gather;
        VolumeGi gi = make_picture(context_.device(), scene, source, p);
        converge(gi, most_, 5 * seconds_);
        for (int step = 0; step < 64 && !interrupted(); ++step) gi.execute();
        gi.finish();
        const Image picture = gi.picture();
        const std::string title = gather ? "gathered" : "composed";
        const ImageError error = image_error(picture, noncaching.picture);
        row.values["psnr_" + title] = error.psnr;
        row.values["ssim_" + title] = error.ssim;
        row.values["psnr_" + title + "_path"] = image_error(picture, path.picture).psnr;
        shown[title] = to_picture(picture);
        shown[title + "_error"] = error_picture(picture, noncaching.picture, 4);
    }
    return {row};
}

/// Table 1: rows in the order of kCaches, against the first.
std::vector<Row> PaperVolume::caches(const VolumeScene& scene) {
    const VolumeSource source = scene.load();
    Image full;
    std::vector<Row> rows;
    for (const CacheKind& kind : kCaches) {
        VolumeGiParams p = params(VolumeMode::caching);
        p.cache_scale = kind.scale;
        p.cache_format = kind.format;
        VolumeGi gi = make_picture(context_.device(), scene, source, p);
        const double gpu = converge(gi, most_, 5 * seconds_);
        // Of one seed, so that jitter is the same in all pictures.
        for (int step = 0; step < 16 && !interrupted(); ++step) gi.execute();
        gi.finish();
        const Image picture = gi.picture();
        if (rows.empty()) full = picture;
        const ImageError error = image_error(picture, full);
        const VolumeStatistics now = gi.statistics();
        rows.push_back({.knob = double(rows.size()),
            .values = {{"psnr", error.psnr}, {"ssim", error.ssim}, {"gpu_seconds", gpu},
                {"cells", double(now.cells)}, {"cell_bytes", double(now.cell_bytes)},
                {"bytes_per_voxel", double(now.cell_bytes) / double(source.volume.voxel_count())},
                {"converged", now.cache_converged ? 1.0 : 0.0}}});
    }
    return rows;
}

/// Frames with the camera moved each time: noncaching, caching while the cache is refined, caching
/// with the cache at rest, path.
std::vector<Row> PaperVolume::frame_rates(const VolumeScene& scene) {
    const VolumeSource source = scene.load();
    std::vector<Row> rows;
    const auto frames = [&](VolumeGi& gi, const Camera& from) {
        std::vector<double> seconds;
        for (int i = 1; i <= 9 && !interrupted(); ++i) {
            gi.set_camera(turned(from, glm::vec3(0), UpAxis::z, 0.05f * float(i)));
            gi.execute();
            seconds.push_back(gpu_seconds(gi.executor()));
        }
        const double frame = seconds.empty() ? 1.0 : spread(seconds).median;
        const double pixels = double(frame_side_) * frame_side_;
        rows.push_back({.knob = double(rows.size()),
            .values = {{"frame_ms", 1e3 * frame}, {"frames_per_second", 1 / frame},
                {"mpixels_per_second", 1e-6 * pixels / frame}}});
    };
    for (const VolumeMode mode : {VolumeMode::path, VolumeMode::noncaching, VolumeMode::caching}) {
        VolumeGiParams p = params(mode);
        p.width = p.height = frame_side_;
        p.cache_error = 0.25f;
        VolumeGi gi = make_picture(context_.device(), scene, source, p);
        gi.execute();
        frames(gi, scene.view());
        if (mode != VolumeMode::caching) continue;
        converge(gi, most_, seconds_);
        gi.set_refining(false);
        frames(gi, scene.view());
    }
    return rows;
}

/// Bytes per pixel of each mode, from pictures of two sizes; bytes per voxel of the cache.
std::vector<Row> PaperVolume::memory(const VolumeScene& scene) {
    const VolumeSource source = scene.load();
    std::vector<Row> rows;
    const auto bytes_of = [&](VolumeGiParams p, std::uint32_t side, VolumeStatistics* statistics) {
        const std::uint64_t before = context_.device().allocator().bytes_used();
        p.width = p.height = side;
        VolumeGi gi = make_picture(context_.device(), scene, source, p);
        gi.execute();
        if (statistics != nullptr) *statistics = gi.statistics();
        return static_cast<double>(context_.device().allocator().bytes_used() - before);
    };
    for (const VolumeMode mode : {VolumeMode::path, VolumeMode::noncaching, VolumeMode::caching}) {
        VolumeGiParams p = params(mode);
        if (mode == VolumeMode::caching) p.cache_scale = 1, p.cache_format = CacheFormat::fp32;
        VolumeStatistics full, kept;
        const double small = bytes_of(p, 128, &full), large = bytes_of(p, 256, nullptr);
        Row row{.knob = double(rows.size()),
            .values = {{"bytes_per_pixel", (large - small) / (256.0 * 256 - 128.0 * 128)}}};
        if (mode == VolumeMode::caching) {
            const auto voxels = double(source.volume.voxel_count());
            p.cache_scale = 2, p.cache_format = CacheFormat::fp16;
            bytes_of(p, 128, &kept);
            row.values["full_bytes_per_voxel"] = double(full.cell_bytes) / voxels;
            row.values["bytes_per_voxel"] = double(kept.cell_bytes) / voxels;
        }
        rows.push_back(std::move(row));
    }
    return rows;
}

} // namespace ockham::chart

// SPDX-License-Identifier: Apache-2.0
#include "samples/viewer/volume_technique.hpp"

#include "framework/core/error.hpp"
#include "framework/gpu/device.hpp"
#include "passes/volume/frame.hpp"
#include "samples/viewer/cell_grid.hpp"
#include "shaders/volume/cache.h"

#include <algorithm>
#include <cstring>
#include <set>

namespace ockham::viewer {
namespace {

constexpr const char* kMajorantCells = "majorant cells";
constexpr const char* kCacheCells = "cache cells";

const std::set<std::string> kViewNames{"density-scale", "albedo", "phase-g", "light", "crop",
    "clip-plane", "volume-gain", "iso", "iso-material", "shading", "surface-gain", "max-bounces",
    "seed"};

} // namespace

void declare(Params& params, VolumeViewerOptions& o) {
    add_volume_options(params, o.volume);
    declare_method(params, o);
}

void declare_method(Params& params, VolumeViewerOptions& o) {
    add_volume_gi_options(params, o.method);
    params.add("steps", &o.steps, "samples per pixel, after which a picture that is still is done")
        .range(1, 1 << 24)
        .group("Method");
}

VolumeTechnique::VolumeTechnique(
    gpu::Device& device, const CommonOptions& common, const VolumeViewerOptions& options, Empty)
    : device_(device), common_(common), options_(options) {}

VolumeTechnique::VolumeTechnique(
    gpu::Device& device, const CommonOptions& common, const VolumeViewerOptions& options)
    : VolumeTechnique(device, common, options, Empty{}) {
    VolumeTechnique::load();
    camera_ = VolumeTechnique::stage().camera;
}

VolumeTechnique::VolumeTechnique(gpu::Device& device, const CommonOptions& common,
    VolumeSource source, const VolumeViewerOptions& options,
    const std::optional<VolumePlace>& place)
    : device_(device), common_(common), own_(options), options_(*own_) {
    take(std::move(source), place);
}

void VolumeTechnique::load() { take(load_volume_source(options_.volume), {}); }

void VolumeTechnique::take(VolumeSource source, const std::optional<VolumePlace>& place) {
    forget();
    source_ = std::move(source);
    place_ = place;
    apply(options_.method, source_.view);
    histogram_ = ockham::histogram(source_.volume, 256);
}

void VolumeTechnique::forget() {
    picture_.reset();
    finished_ = false;
}

void VolumeTechnique::relight() { update_view(options_.volume, source_); }

std::string VolumeTechnique::title() const { return source_.volume.name; }

Stage VolumeTechnique::stage() const {
    Camera camera = volume_camera();
    if (!common_.camera.empty()) {
        const std::optional<Camera> given = parse_camera(common_.camera, UpAxis::z);
        if (!given)
            fail_input("--camera: found '{}', expected \"px,py,pz tx,ty,tz fov\"", common_.camera);
        camera = *given;
    }
    camera.orthographic_height = common_.orthographic;
    return {camera, glm::vec3(0.0f), 1.0f, UpAxis::z};
}

/// One picture does not pay for a cache, but a person looks at many.
VolumeMode VolumeTechnique::mode() const {
    constexpr std::uint64_t kMany = 1000;
    if (const std::optional<VolumeMode> given = volume_mode(options_.method)) return *given;
    return choose_mode(source_.volume, kMany,
        static_cast<std::uint32_t>(options_.method.cache_scale), device_.allocator().budget_bytes())
        .mode;
}

void VolumeTechnique::change(const std::vector<std::string>& names) {
    bool view = false, transfer = false;
    for (const std::string& name : names) {
        if (name == "steps") continue;
        if (name == "volume") {
            load();
            return;
        }
        if (kViewNames.contains(name))
            view = true;
        else if (name == "transfer" || name == "window")
            transfer = true;
        else
            view = true, picture_.reset(); // another graph, or another environment
    }
    finished_ = false;
    if (view) {
        relight();
        apply(options_.method, source_.view);
        if (medium()) medium()->set_view(source_.view);
    }
    if (transfer) {
        update_transfer(options_.volume, source_);
        if (medium()) medium()->set_transfer(source_.transfer);
    }
    if (picture_ && !medium()) picture_.reset(); // there may be something to see now
}

void VolumeTechnique::set_transfer(const TransferFunction& transfer) {
    source_.transfer = transfer;
    finished_ = false;
    if (medium())
        medium()->set_transfer(transfer);
    else
        picture_.reset();
}

void VolumeTechnique::set_camera(const Camera& camera) {
    camera_ = camera;
    finished_ = false;
    if (picture_) picture_->set_camera(camera);
}

std::unique_ptr<SurfaceVolume> VolumeTechnique::make(const VolumeGiParams& params) const {
    const MediumSource medium{
        source_.volume, source_.transfer, source_.environment, source_.view, {}};
    return std::make_unique<SurfaceVolume>(
        device_, nullptr, medium, camera_, SurfaceVolumeParams{{}, params});
}

void VolumeTechnique::render(glm::uvec2 size, bool hurry) {
    const bool caches = mode() == VolumeMode::caching;
    const bool gather = options_.method.gather && !(caches && hurry);
    const bool changes = size != size_ || gather != gather_;
    if (changes && !medium()) picture_.reset();
    if (!picture_) {
        VolumeGiParams params = volume_gi_params(options_.method, mode());
        params.width = size.x;
        params.height = size.y;
        params.gather = gather;
        params.keep_on_iso = true;
        params.place = place_;
        picture_ = make(params);
    } else if (changes) {
        medium()->set_picture(size.x, size.y, gather);
    }
    size_ = size;
    gather_ = gather;
    VolumeGi* gi = medium();
    if (picture_->all_at_once()) {
        picture_->execute();
        finished_ = !hurry;
        return;
    }
    gi->set_refining(!hurry);
    const auto last = static_cast<std::uint64_t>(options_.steps);
    if (gi->steps() >= last)
        gi->drain(); // what long paths have left undone
    else
        gi->execute();
    finished_ = !hurry && gi->steps() >= last && gi->finished();
}

std::vector<std::string> VolumeTechnique::overlays() const { return {kMajorantCells, kCacheCells}; }

std::optional<Overlay> VolumeTechnique::overlay(const std::string& name) {
    if (!medium()) return {};
    Executor& executor = medium()->executor();
    const bool cache = name == kCacheCells;
    const BufferHandle buffer = executor.graph().find_buffer(cache ? "cache_index" : "majorants");
    if (!buffer) return {}; // one majorant for all, or no cache
    const std::vector<std::byte> bytes = executor.read(buffer);
    CellGrid grid{.place = place_.value_or(place_of(source_.volume)), .dims = source_.volume.dims};
    const glm::ivec2 half = glm::max(glm::ivec2(size_) / 2, glm::ivec2(1));
    if (!cache) {
        grid.side = RANGE_CELL;
        std::vector<float> majorants(bytes.size() / sizeof(float));
        std::memcpy(majorants.data(), bytes.data(), bytes.size());
        Overlay overlay{name, "cells that are not empty along the ray",
            count_cells(grid, camera_, half, [&](std::size_t c) { return majorants[c] > 0; })};
        overlay.high = std::max(1.0f, std::ranges::max(overlay.values.plane(0)));
        return overlay;
    }
    shader::CacheHeader header;
    std::memcpy(&header, bytes.data(), sizeof(header));
    grid.side = std::max(header.scale, 1u);
    const auto has_slot = [&](std::size_t c) {
        std::uint32_t word = CACHE_NONE;
        std::memcpy(&word, bytes.data() + sizeof(header) + c * sizeof(word), sizeof(word));
        return word != CACHE_NONE;
    };
    return Overlay{name, "the first cells that hold light, a colour each",
        color_cells(grid, camera_, half, has_slot)};
}

std::vector<std::string> VolumeTechnique::rivals() const {
    return {
        name_of(VolumeMode::path), name_of(VolumeMode::noncaching), name_of(VolumeMode::caching)};
}

std::unique_ptr<Technique> VolumeTechnique::rival(const std::string& name) {
    VolumeViewerOptions options = options_;
    options.method.mode = name;
    auto other = std::make_unique<VolumeTechnique>(device_, common_, source_, options, place_);
    other->set_camera(camera_);
    return other;
}

std::vector<std::pair<std::string, std::string>> VolumeTechnique::facts() {
    const Volume& v = source_.volume;
    std::vector<std::pair<std::string, std::string>> facts{
        {"voxels", fmt::format("{} x {} x {} {}", v.dims.x, v.dims.y, v.dims.z, name_of(v.type))},
        {"values", fmt::format("{:.5g} to {:.5g}", histogram_.low, histogram_.high)}};
    VolumeGi* gi = medium();
    if (!gi) return facts;
    const VolumeStatistics s = gi->statistics();
    if (!gi->at_rest())
        facts.emplace_back("steps", fmt::format("{} of {}", gi->steps(), options_.steps));
    if (s.relative_error && gi->steps() > 1)
        facts.emplace_back("noise", fmt::format("{:.2g} % of the mean", 100 * *s.relative_error));
    if (s.cells > 0)
        facts.emplace_back("cache", fmt::format("{} cells, {:.0f} MiB, {}", s.cells,
                                        static_cast<double>(s.cell_bytes) / (1 << 20),
                                        s.cache_converged ? "done" : "refining"));
    return facts;
}

std::vector<PassTime> VolumeTechnique::times() {
    return picture_ ? picture_->times() : std::vector<PassTime>{};
}

} // namespace ockham::viewer

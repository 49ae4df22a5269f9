// SPDX-License-Identifier: Apache-2.0
#include "samples/viewer/surface_technique.hpp"

#include "framework/core/error.hpp"

#include <algorithm>

namespace ockham::viewer {
namespace {

constexpr int kTemporalFrames = 32; ///< after which --method taa has settled

/// What overlays need beside the counts, which are always there.
bool needs_aov(const std::string& overlay) {
    return overlay == "winner" || overlay == "normal" || overlay == "depth" ||
           overlay == "material";
}

/// Useful share of eight neighbouring lanes, were each to loop over its own pixel's samples.
Image lane_use(const Image& counts) {
    constexpr int kLanes = 8;
    Image use(counts.width(), counts.height(), {"lane_use"});
    for (int y = 0; y < counts.height(); ++y) {
        for (int x0 = 0; x0 < counts.width(); x0 += kLanes) {
            const int x1 = std::min(x0 + kLanes, counts.width());
            float sum = 0, most = 0;
            for (int x = x0; x < x1; ++x) {
                sum += counts.at(x, y, 0);
                most = std::max(most, counts.at(x, y, 0));
            }
            for (int x = x0; x < x1; ++x)
                use.at(x, y, 0) = sum / (most * static_cast<float>(x1 - x0));
        }
    }
    return use;
}

/// The first three channels, each from `low` and `high` to 0 and 1.
Image colors_of(const Image& image, float low, float high) {
    Image out(image.width(), image.height(), {"R", "G", "B"});
    for (int c = 0; c < 3; ++c)
        std::ranges::transform(image.plane(c), out.plane(c).begin(),
            [&](float v) { return std::clamp((v - low) / (high - low), 0.0f, 1.0f); });
    return out;
}

Image channel_of(const Image& image, int channel) {
    Image out(image.width(), image.height(), {"value"});
    std::ranges::copy(image.plane(channel), out.plane(0).begin());
    return out;
}

} // namespace

void declare(Params& params, SurfaceOptions& o) {
    add_scene_options(params, o.scene);
    add_aa_options(params, o.method);
}

Stage stage_of(const LitScene& lit, const CommonOptions& common) {
    const Bounds& bounds = lit.gpu().bounds();
    Stage stage{choose_camera(common, lit.scene(), bounds), bounds.center(),
        std::max(bounds.radius(), 1e-6f), UpAxis::y};
    const glm::vec3 p = stage.camera.position;
    stage.inside =
        glm::all(glm::lessThan(bounds.low, p)) && glm::all(glm::lessThan(p, bounds.high));
    return stage;
}

SampleGrid sample_grid(const Image& samples, const AdaptiveAaParams& method,
    const std::optional<Image>& counts, glm::ivec2 pixel) {
    const AdaptiveAaParams all = settled(method);
    const std::uint32_t n = all.m * all.m;
    SampleGrid grid{.m = all.m, .radiance = {}, .ranks = std::vector<std::uint32_t>(n)};
    for (std::size_t i = 0; i < n; ++i)
        grid.radiance.emplace_back(samples.plane(0)[i], samples.plane(1)[i], samples.plane(2)[i]);
    for (std::uint32_t rank = 0; rank < n; ++rank) grid.ranks[all.order[rank]] = rank;
    if (counts && needs_counts(all)) {
        grid.count = static_cast<std::uint32_t>(counts->at(pixel.x, pixel.y, 0));
        grid.by_rank = all.resolve == Resolve::prefix || grid.count == n;
    } else if (all.method == AaMethod::uniform || all.method == AaMethod::ssaa) {
        grid.count = all.k;
    }
    return grid;
}

SurfaceTechnique::SurfaceTechnique(
    gpu::Device& device, const CommonOptions& common, const SurfaceOptions& options)
    : device_(device), common_(common), options_(options) {
    load();
    change({});
    camera_ = stage().camera;
}

SurfaceTechnique::SurfaceTechnique(gpu::Device& device, const CommonOptions& common,
    std::shared_ptr<const LitScene> lit, const SurfaceOptions& options)
    : device_(device), common_(common), own_(options), options_(*own_), lit_(std::move(lit)) {
    change({});
    camera_ = stage().camera;
}

void SurfaceTechnique::load() {
    Scene scene = load_scenes(options_.scene, common_);
    forget();
    lit_.reset(); // before the next is uploaded
    lit_ = std::make_shared<const LitScene>(device_, std::move(scene));
}

std::string SurfaceTechnique::title() const {
    const std::vector<std::string>& scenes = options_.scene.scenes;
    return scenes.empty() ? "builtin:atrium" : fmt::format("{}", fmt::join(scenes, " "));
}

void SurfaceTechnique::change(const std::vector<std::string>& names) {
    const bool reload = std::ranges::any_of(names, [](const std::string& name) {
        return name == "scene" || name == "rig" || name == "roughness" || name == "lights" ||
               name == "environment";
    });
    if (reload) load();
    AdaptiveAaParams params = aa_params(options_.method);
    params.history = false; // each view is on its own
    params.export_counts = true;
    params.aov = needs_aov(wanted_);
    params_ = params;
    forget();
}

void SurfaceTechnique::forget() {
    hasty_ = {};
    full_ = {};
    clusters_ = {};
    samples_ = {};
    shown_ = nullptr;
    frames_ = 0;
    finished_ = false;
}

void SurfaceTechnique::set_camera(const Camera& camera) {
    camera_ = camera;
    frames_ = 0;
    finished_ = false;
}

AdaptiveAa& SurfaceTechnique::slot(glm::uvec2 size, bool hurry) {
    Slot& slot = hurry ? hasty_ : full_;
    if (!slot.aa || slot.size != size) {
        if (shown_ == slot.aa.get()) shown_ = nullptr;
        slot = {}; // first, for the memory
        AdaptiveAaParams params = params_;
        params.width = size.x;
        params.height = size.y;
        slot = {std::make_unique<AdaptiveAa>(device_, *lit_, camera_, params), size};
    }
    return *slot.aa;
}

void SurfaceTechnique::render(glm::uvec2 size, bool hurry) {
    AdaptiveAa& aa = slot(size, hurry);
    aa.set_camera(camera_);
    aa.execute();
    shown_ = &aa;
    frames_ = hurry ? 0 : frames_ + 1;
    finished_ = frames_ >= (params_.method == AaMethod::taa ? kTemporalFrames : 1);
}

std::vector<std::string> SurfaceTechnique::overlays() const {
    return {"k", "winner", "clusters", "lane use", "normal", "depth", "material"};
}

void SurfaceTechnique::want_overlay(const std::string& name) {
    const bool other = needs_aov(name) != needs_aov(wanted_);
    wanted_ = name;
    if (other) change({});
}

std::optional<Overlay> SurfaceTechnique::overlay(const std::string& name) {
    if (!shown_) return {};
    const AdaptiveAaOutputs& out = shown_->outputs();
    const auto n = static_cast<float>(params_.m * params_.m);
    if (name == "k" || name == "lane use") {
        if (!out.sample_count) return {};
        const Image counts = shown_->read(out.sample_count);
        if (name == "k") return Overlay{name, "samples per pixel", channel_of(counts, 0), 1, n};
        return Overlay{name, "useful share of 8 lanes, were each to loop over its own pixel",
            lane_use(counts), 0, 1};
    }
    if (name == "clusters")
        return Overlay{name, "surfaces that a pixel sees, up to 4", cluster_counts(), 1, 4};
    if (!params_.aov || !out.aov_surface) return {};
    if (name == "winner" && out.winner)
        return Overlay{name,
            "what asked for samples: 0 nothing, 1 depth, 2 normals, 3 shading, 4 several surfaces, "
            "5 variation",
            channel_of(shown_->read(out.winner), 0), 0, 5};
    if (name == "normal")
        return Overlay{name, "world normal, -1 to 1 as colour",
            colors_of(shown_->read(out.aov_surface), -1, 1)};
    if (name == "depth") {
        Overlay overlay{name, "distance along the view, scene units",
            channel_of(shown_->read(out.aov_surface), 3)};
        float far = 0;
        for (float& depth : overlay.values.plane(0)) {
            if (!std::isfinite(depth)) depth = 0;
            far = std::max(far, depth);
        }
        overlay.high = far;
        return overlay;
    }
    if (name == "material") {
        Overlay overlay{
            name, "index of the material", channel_of(shown_->read(out.aov_material), 0)};
        overlay.high = static_cast<float>(std::max<std::size_t>(lit_->scene().materials.size(), 1));
        return overlay;
    }
    return {};
}

/// By the method that takes a sample of each: its counts are what is wanted.
Image SurfaceTechnique::cluster_counts() {
    const Image shown = shown_->picture();
    const glm::uvec2 size(shown.width(), shown.height());
    if (!clusters_.aa || clusters_.size != size) {
        AdaptiveAaParams params;
        params.width = size.x;
        params.height = size.y;
        params.m = std::max(params_.m, 2u);
        params.method = AaMethod::cluster;
        params.export_counts = true;
        clusters_ = {};
        clusters_ = {std::make_unique<AdaptiveAa>(device_, *lit_, camera_, params), size};
    }
    clusters_.aa->set_camera(camera_);
    clusters_.aa->execute();
    return channel_of(clusters_.aa->read(clusters_.aa->outputs().sample_count), 0);
}

/// Pixels of a picture m times as large are samples of this one.
std::optional<SampleGrid> SurfaceTechnique::samples(glm::ivec2 pixel) {
    if (!shown_ || filters_picture(params_.method)) return {};
    const glm::uvec2 size = shown_ == full_.aa.get() ? full_.size : hasty_.size;
    if (glm::any(glm::greaterThanEqual(glm::uvec2(pixel), size))) return {};
    const std::uint32_t m = settled(params_).m;
    if (!samples_.aa || samples_.size != size) {
        AdaptiveAaParams params;
        params.width = params.height = m;
        params.m = 1;
        params.method = AaMethod::none;
        params.anisotropy = params_.anisotropy;
        params.part_of = m * size;
        samples_ = {};
        samples_ = {std::make_unique<AdaptiveAa>(device_, *lit_, camera_, params), size};
    }
    samples_.aa->set_camera(camera_);
    samples_.aa->set_origin(m * glm::uvec2(pixel));
    samples_.aa->execute();
    std::optional<Image> counts;
    if (const ImageHandle image = shown_->outputs().sample_count) counts = shown_->read(image);
    return sample_grid(samples_.aa->picture(), params_, counts, pixel);
}

std::vector<std::string> SurfaceTechnique::rivals() const {
    Params params;
    AaOptions options;
    add_aa_options(params, options);
    return params.find("method")->allowed;
}

std::unique_ptr<Technique> SurfaceTechnique::rival(const std::string& name) {
    SurfaceOptions options = options_;
    options.method.method = name;
    auto other = std::make_unique<SurfaceTechnique>(device_, common_, lit_, options);
    other->set_camera(camera_);
    return other;
}

std::vector<std::pair<std::string, std::string>> SurfaceTechnique::facts() {
    std::vector<std::pair<std::string, std::string>> facts{
        {"triangles", fmt::format("{}", lit_->gpu().facts().triangles)},
        {"lights", fmt::format("{}", lit_->scene().lights.size())}};
    if (!shown_) return facts;
    const AdaptiveAa::SampleCounts counts = shown_->sample_counts();
    facts.emplace_back(
        "samples", fmt::format("{:.1f} %, {:.2f} per pixel", counts.percent, counts.mean));
    facts.emplace_back("lanes", fmt::format("{:.0f} % useful", 100 * counts.lane_efficiency));
    const AdaptiveAa::Fit& fit = shown_->fit();
    facts.emplace_back("g-buffer",
        fmt::format("{}{}", fit.layout == GbufferLayout::packed ? "packed" : "visibility",
            shown_->tile_count() > 1 ? fmt::format(", {} tiles", shown_->tile_count()) : ""));
    return facts;
}

std::vector<PassTime> SurfaceTechnique::times() {
    return shown_ ? shown_->times() : std::vector<PassTime>{};
}

} // namespace ockham::viewer

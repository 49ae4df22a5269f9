// SPDX-License-Identifier: Apache-2.0
#include "samples/viewer/surface_volume_technique.hpp"

#include "framework/core/error.hpp"

#include <algorithm>
#include <set>

namespace ockham::viewer {
namespace {

constexpr const char* kMeshesAlone = "meshes alone";
constexpr const char* kMediumAlone = "medium alone";
constexpr const char* kSamples = "k";
constexpr std::uint32_t kPathsPerSample = 256; ///< of what the loupe shows, at a time

/// What is in the scene, or shines in it.
const std::set<std::string> kSceneNames{
    "input", "rig", "roughness", "lights", "environment", "light"};

/// Those whose pictures are means of samples.
const std::vector<std::string> kMeshMethods{"none", "uniform", "cluster", "ssaa", "adaptive"};

} // namespace

void declare(Params& params, SurfaceVolumeOptions& o) {
    add_world_options(params, o.world, o.surface.scene, o.volume.volume);
    add_aa_options(params, o.surface.method);
    declare_method(params, o.volume);
}

SurfaceVolumeTechnique::SurfaceVolumeTechnique(
    gpu::Device& device, const CommonOptions& common, const SurfaceVolumeOptions& options)
    : VolumeTechnique(device, common, options.volume, Empty{}), options_(options) {
    SurfaceVolumeTechnique::load();
    camera_ = SurfaceVolumeTechnique::stage().camera;
}

SurfaceVolumeTechnique::SurfaceVolumeTechnique(gpu::Device& device, const CommonOptions& common,
    std::shared_ptr<const LitScene> lit, const VolumeSource& source,
    const SurfaceVolumeOptions& options)
    : VolumeTechnique(device, common, source, options.volume, {}), own_(options), options_(*own_),
      lit_(std::move(lit)) {
    SurfaceVolumeTechnique::change({"place"});
}

void SurfaceVolumeTechnique::load() {
    World world =
        load_world(options_.world, options_.surface.scene, options_.volume.volume, common_);
    if (!world.scene || !world.volume)
        fail_input("'{}': a scene with a volume in it has both; found no {}",
            fmt::join(options_.world.inputs, "', '"), world.scene ? "volume" : "scene");
    forget();
    lit_.reset(); // before the next is uploaded
    lit_ = std::make_shared<const LitScene>(device_, std::move(*world.scene));
    placement_ = world.placement;
    const VolumePlace place = placed(place_of(world.volume->volume), placement_);
    take(std::move(*world.volume), place);
}

void SurfaceVolumeTechnique::relight() {
    update_view(options_.world, options_.volume.volume, lit_->scene(), source_);
}

std::unique_ptr<SurfaceVolume> SurfaceVolumeTechnique::make(const VolumeGiParams& params) const {
    SurfaceVolumeParams both{aa_params(options_.surface.method), params};
    both.surfaces.history = false; // each view is on its own
    both.surfaces.export_counts = true;
    return make(both);
}

std::unique_ptr<SurfaceVolume> SurfaceVolumeTechnique::make(
    const SurfaceVolumeParams& params) const {
    const MediumSource medium{
        source_.volume, source_.transfer, source_.environment, source_.view, placement_};
    return std::make_unique<SurfaceVolume>(device_, lit_.get(), medium, camera_, params);
}

std::string SurfaceVolumeTechnique::title() const {
    const std::vector<std::string>& inputs = options_.world.inputs;
    return inputs.empty() ? "builtin:atrium builtin:cloud"
                          : fmt::format("{}", fmt::join(inputs, " "));
}

void SurfaceVolumeTechnique::change(const std::vector<std::string>& names) {
    const auto any = [&](const std::set<std::string>& of) {
        return std::ranges::any_of(names, [&](const auto& name) { return of.contains(name); });
    };
    if (any(kSceneNames)) {
        forget_samples();
        load();
        return;
    }
    if (std::ranges::find(names, "place") != names.end()) {
        placement_ = parse_place(options_.world.place);
        place_ = placed(place_of(source_.volume), placement_);
    }
    VolumeTechnique::change(names);
    // As of the picture, only the view is another where the graph is not.
    if (!picture_ || any({"transfer", "window"}))
        forget_samples();
    else if (samples_.picture)
        samples_.picture->medium()->set_view(source_.view);
}

void SurfaceVolumeTechnique::set_camera(const Camera& camera) {
    VolumeTechnique::set_camera(camera);
    if (samples_.picture) samples_.picture->set_camera(camera);
}

void SurfaceVolumeTechnique::set_transfer(const TransferFunction& transfer) {
    forget_samples();
    VolumeTechnique::set_transfer(transfer);
}

void SurfaceVolumeTechnique::render(glm::uvec2 size, bool hurry) {
    if (!hurry && samples_.size != size) forget_samples(); // before the next picture takes memory
    VolumeTechnique::render(size, hurry);
}

std::vector<std::string> SurfaceVolumeTechnique::overlays() const {
    std::vector<std::string> names = VolumeTechnique::overlays();
    names.insert(names.begin(), kSamples);
    return names;
}

std::optional<Overlay> SurfaceVolumeTechnique::overlay(const std::string& name) {
    if (name != kSamples) return VolumeTechnique::overlay(name);
    if (!picture_) return {};
    const std::optional<Image> counts = picture_->sample_counts();
    if (!counts) return {};
    const auto m = static_cast<float>(settled(aa_params(options_.surface.method)).m);
    return Overlay{name, "samples of surfaces per pixel", *counts, 1, m * m};
}

/// Pixels of a picture m times as large are samples of this one. A cache for so few would cost more
/// than the paths that it stands for.
std::optional<SampleGrid> SurfaceVolumeTechnique::samples(glm::ivec2 pixel) {
    const AdaptiveAaParams method = aa_params(options_.surface.method);
    if (!picture_ || filters_picture(method.method)) return {};
    if (const VolumeGi* medium = picture_->medium(); medium && !medium->meshes()) return {};
    if (glm::any(glm::greaterThanEqual(glm::uvec2(pixel), size_))) return {};
    const std::uint32_t m = settled(method).m;
    if (!samples_.picture || samples_.size != size_) {
        SurfaceVolumeParams params{.surfaces = {},
            .medium = volume_gi_params(options_.volume.method,
                mode() == VolumeMode::path ? VolumeMode::path : VolumeMode::noncaching)};
        params.surfaces.m = 1;
        params.surfaces.method = AaMethod::none;
        params.surfaces.anisotropy = method.anisotropy;
        params.medium.width = params.medium.height = m;
        params.medium.part_of = m * size_;
        params.medium.samples_per_step = kPathsPerSample;
        params.medium.search = SurfaceSearch::exact; // others are for the composition
        forget_samples();
        samples_ = {.picture = make(params), .size = size_, .pixel = glm::ivec2(-1)};
    }
    SurfaceVolume& samples = *samples_.picture;
    if (samples_.pixel != pixel) samples.set_origin(m * glm::uvec2(pixel));
    samples_.pixel = pixel;
    samples.execute();
    samples.finish();
    SampleGrid grid = sample_grid(samples.picture(), method, picture_->sample_counts(), pixel);
    if (!samples.all_at_once()) grid.paths = kPathsPerSample * samples.medium()->steps();
    return grid;
}

std::string SurfaceVolumeTechnique::method() const {
    return fmt::format("{}, {}", options_.surface.method.method, VolumeTechnique::method());
}

std::vector<std::string> SurfaceVolumeTechnique::rivals() const {
    std::vector<std::string> names{kMeshesAlone, kMediumAlone};
    for (const std::string& mode : VolumeTechnique::rivals()) names.push_back(mode);
    for (const std::string& method : kMeshMethods) names.push_back(method);
    return names;
}

std::unique_ptr<Technique> SurfaceVolumeTechnique::rival(const std::string& name) {
    std::unique_ptr<Technique> other;
    if (name == kMeshesAlone) {
        other = std::make_unique<SurfaceTechnique>(device_, common_, lit_, options_.surface);
    } else if (name == kMediumAlone) {
        other =
            std::make_unique<VolumeTechnique>(device_, common_, source_, options_.volume, place_);
    } else {
        SurfaceVolumeOptions options = options_;
        const bool is_method = std::ranges::find(kMeshMethods, name) != kMeshMethods.end();
        (is_method ? options.surface.method.method : options.volume.method.mode) = name;
        other = std::make_unique<SurfaceVolumeTechnique>(device_, common_, lit_, source_, options);
    }
    other->set_camera(camera_);
    return other;
}

std::vector<std::pair<std::string, std::string>> SurfaceVolumeTechnique::facts() {
    auto facts = VolumeTechnique::facts();
    facts.insert(facts.begin(), {"triangles", fmt::format("{}", lit_->gpu().facts().triangles)});
    if (!picture_) return facts;
    if (const std::optional<double> percent = picture_->sample_percent())
        facts.emplace_back("samples", fmt::format("{:.1f} % of those of surfaces", *percent));
    return facts;
}

} // namespace ockham::viewer

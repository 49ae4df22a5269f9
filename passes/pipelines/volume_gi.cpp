// SPDX-License-Identifier: Apache-2.0
#include "passes/pipelines/volume_gi.hpp"

#include "framework/core/error.hpp"
#include "framework/gpu/device.hpp"
#include "passes/volume/frame.hpp"
#include "passes/volume/majorants.hpp"
#include "passes/volume/meshes.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace ockham {
namespace {

constexpr const char* kProgress = "progress";  ///< a saved resource of no graph
constexpr std::uint32_t kDepthCandidates = 64; ///< of the stochastic search, per pixel and step

VolumeGiParams checked(const VolumeGiParams& params) {
    if (params.width < 1 || params.height < 1 || params.width > 16384 || params.height > 16384) {
        fail_input(
            "picture of {} x {} pixels: each side must be 1 to 16384", params.width, params.height);
    }
    check(params.iterations >= 1, "a loop budget");
    if (params.samples_per_step < 1) fail_input("0 samples per step: each step must take some");
    const bool composes = params.mode == VolumeMode::caching && !params.gather;
    if (params.search != SurfaceSearch::exact && !composes) {
        fail_input("surface search: paths meet surfaces from anywhere and in any direction, and an "
                   "image of depths knows camera rays through pixel centres alone; a stochastic or "
                   "marched one is for the composition, --mode caching --gather off");
    }
    return params;
}

/// What of the cache's light or medium is another. Cameras, materials and gains are of no concern.
/// `occlusion`: surfaces are of some.
CacheChange cache_change(
    const shader::VolumeFrame& a, const shader::VolumeFrame& b, bool occlusion) {
    const auto planes = [](const shader::VolumeFrame& f) {
        return std::vector<glm::vec4>(f.clip_planes, f.clip_planes + f.clip_count);
    };
    if (a.crop_min != b.crop_min || a.crop_max != b.crop_max || planes(a) != planes(b))
        return CacheChange::medium;
    const bool light = a.light_direction != b.light_direction ||
                       a.light_irradiance != b.light_irradiance || a.environment != b.environment ||
                       a.density_scale != b.density_scale || a.albedo != b.albedo ||
                       a.phase_g != b.phase_g || a.max_bounces != b.max_bounces || a.seed != b.seed;
    bool surface = occlusion && a.surface_count != b.surface_count;
    for (std::uint32_t i = 0; occlusion && i < std::min(a.surface_count, b.surface_count); ++i) {
        surface = surface || a.surfaces[i].value != b.surfaces[i].value ||
                  a.surfaces[i].opacity != b.surfaces[i].opacity;
    }
    if (light && surface) return CacheChange::medium;
    return light ? CacheChange::light : surface ? CacheChange::surface : CacheChange::none;
}

bool has_opaque(const VolumeView& view) {
    return std::ranges::any_of(view.surfaces, [](const auto& s) { return s.opacity >= 1; });
}
bool has_translucent(const VolumeView& view) {
    return std::ranges::any_of(view.surfaces, [](const auto& s) { return s.opacity < 1; });
}

Bounds bounds_of(const VolumePlace& place) {
    Bounds box;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 unit(corner & 1, corner >> 1 & 1, corner >> 2);
        box.add(glm::vec3(place.corner + place.edges * unit));
    }
    return box;
}

/// Light goes on in other directions than the camera's: surfaces scatter in mode path alone.
bool scatters(const VolumeView& view, VolumeMode mode) {
    const bool surfaces = mode == VolumeMode::path && !view.surfaces.empty();
    return view.max_bounces > 0 && ((view.density_scale > 0 && view.albedo > 0) || surfaces);
}

CacheChange both(CacheChange a, CacheChange b) {
    if (a == CacheChange::none || a == b) return b;
    return b == CacheChange::none ? a : CacheChange::medium;
}

double luminance(const Image& image, std::size_t i) {
    return 0.2126 * image.plane(0)[i] + 0.7152 * image.plane(1)[i] + 0.0722 * image.plane(2)[i];
}

std::uint64_t number_of(glm::uvec2 words) { return std::uint64_t{words.y} << 32 | words.x; }

} // namespace

const char* name_of(VolumeMode mode) {
    return mode == VolumeMode::path         ? "path"
           : mode == VolumeMode::noncaching ? "noncaching"
                                            : "caching";
}

ModeChoice choose_mode(const Volume& volume, std::uint64_t pictures, std::uint32_t cache_scale,
    std::uint64_t budget_bytes) {
    if (pictures < 2) {
        return {VolumeMode::path,
            "one picture shares its light with no other, and paths are the reference"};
    }
    const std::uint64_t cells =
        volume.voxel_count() / (std::uint64_t{cache_scale} * cache_scale * cache_scale);
    const std::uint64_t bytes = 12 * cells; // an index and three halves each, were all visible
    if (budget_bytes > 0 && bytes > budget_bytes / 2) {
        return {VolumeMode::path, fmt::format("a cache for all {} pictures may take {} of {} MiB",
                                      pictures, bytes >> 20, budget_bytes >> 20)};
    }
    return {VolumeMode::caching, fmt::format("{} pictures share the light in a cache", pictures)};
}

VolumeGi::VolumeGi(gpu::Device& device, const Volume& volume, const TransferFunction& transfer,
    const Image& environment, const VolumeView& view, const Camera& camera,
    const VolumeGiParams& params, std::unique_ptr<MeshBackground> meshes)
    : device_(device), place_(params.place.value_or(place_of(volume))),
      gpu_(device, volume, transfer, environment), view_(view), camera_(camera),
      params_(checked(params)), meshes_(std::move(meshes)),
      frame_(device, gpu::BufferInfo{.bytes = sizeof(shader::VolumeFrame),
                         .usage = VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT,
                         .name = "frame",
                         .memory = gpu::MemoryUse::upload}) {
    check(!meshes_ || meshes_->params().part_of == params_.part_of, "both show the same part");
    if (meshes_ && gpu_.facts().environment_map)
        fail_input("--environment: meshes have one colour behind them; found a map");
    refuse_search(view);
    show(view, camera);
    if (caching()) cache_size_ = count_cache_cells(device_, gpu_, frame_, cache_params());
    Graph graph = declare();
    executor_ = std::make_unique<Executor>(device, std::move(graph));
    bind();
}

void VolumeGi::refuse_search(const VolumeView& view) const {
    if (!meshes_ || view.surfaces.empty() || params_.search == SurfaceSearch::exact) return;
    fail_input("--surface-search: among meshes, isosurfaces are met by rays through samples of the "
               "G-buffer; use exact");
}

void VolumeGi::show(const VolumeView& view, const Camera& camera) {
    const glm::uvec2 size(params_.width, params_.height);
    const bool part = params_.part_of.x > 0;
    const glm::uvec2 picture = part ? params_.part_of : size;
    check(glm::all(glm::lessThanEqual(origin_ + size, picture)), "a part lies inside its picture");
    shader::VolumeFrame frame = make_volume_frame(place_, gpu_, camera, picture.x, picture.y, view);
    if (part) set_part(frame, size, origin_);
    if (meshes_) {
        meshes_->show(camera, size, origin_, has_opaque(view) ? bounds_of(place_) : Bounds{});
        meshes_->describe(frame);
    }
    std::memcpy(frame_.mapped().data(), &frame, sizeof(frame));
    view_ = view;
    camera_ = camera;
}

CacheParams VolumeGi::cache_params() const {
    CacheParams p;
    p.scale = params_.cache_scale;
    p.format = params_.cache_format;
    p.directional = view_.phase_g != 0;
    p.occlusion = params_.iso_occlusion;
    p.hold_solid = params_.keep_on_iso && !view_.surfaces.empty();
    p.target_error = params_.cache_error;
    p.capacity = std::max(cache_size_.slots, 1u);
    return p;
}

bool VolumeGi::at_rest() const {
    const bool empty = view_.density_scale == 0 || gpu_.max_opacity() == 0;
    return meshes_ && empty && params_.mode != VolumeMode::path && has_opaque(view_) &&
           !has_translucent(view_);
}

Graph VolumeGi::declare() {
    Graph graph("volume_gi");
    const VolumeFacts& facts = gpu_.facts();
    medium_ = {.facts = facts,
        .handles = gpu_.import(graph),
        .frame = graph.import_buffer("frame", {sizeof(shader::VolumeFrame)}, {}),
        .ranges = {},
        .majorants = {},
        .surfaces = !view_.surfaces.empty(),
        .opaque = meshes_ && has_opaque(view_),
        .translucent = has_translucent(view_),
        .sobol = params_.sobol};
    if (!facts.emission) graph.omit_resource("emission", "the transfer function emits nothing");
    if (!facts.environment_map) graph.omit_resource("environment", "the environment is one colour");
    new_view_ = graph.add_condition("new view");
    restart_ = graph.add_condition("new picture");
    drain_ = graph.add_condition("finish");
    declare_majorants(graph);
    if (meshes_)
        medium_.meshes = meshes_->declare(graph, medium_,
            {.rays = !at_rest(), .scatters = scatters(view_, params_.mode)}, new_view_);
    if (meshes_ && !medium_.opaque) {
        graph.omit_pass(
            "gbuffer, isosurfaces", medium_.surfaces ? "no isosurface is opaque" : "no --iso");
    }
    cache_.reset();
    composed_.reset();
    if (at_rest()) {
        for (const char* pass :
            {"mesh_ends", "mesh_radiance", "cache", "path_trace", "compose", "over_meshes"})
            graph.omit_pass(pass, "no density, and all isosurfaces are opaque: the samples of the "
                                  "G-buffer are all that is seen");
        radiance_ = medium_.meshes.picture;
    } else {
        declare_light(graph);
    }
    if (!params_.no_meshes.empty()) {
        for (const char* pass : {"gbuffer", "first_sample", "metrics", "buckets", "shade",
                 "resolve", "mesh_ends", "mesh_radiance", "over_meshes"})
            graph.omit_pass(pass, params_.no_meshes);
        graph.omit_resource("mesh_tree", params_.no_meshes);
    }
    graph.export_resource(radiance_, "the picture");
    declare_captures(graph);
    return graph;
}

void VolumeGi::declare_light(Graph& graph) {
    if (caching()) {
        declare_cache(graph);
    } else {
        graph.omit_pass("cache",
            fmt::format("--mode {}: every path finds its own light", name_of(params_.mode)));
    }
    declare_picture(graph);
    if (meshes_) {
        const MeshRays rays{.progress = traces() ? paths_.progress : BufferHandle{},
            .count = composed_ ? composed_->count : ImageHandle{}};
        radiance_ = add_over_meshes(graph, medium_.meshes, radiance_, rays, meshes_->params().m);
    }
}

void VolumeGi::declare_majorants(Graph& graph) {
    new_volume_ = graph.add_condition("new volume");
    new_transfer_ = graph.add_condition("new transfer function");
    const Majorants majorants = add_majorants(graph, medium_.facts, medium_.handles, medium_.frame,
        medium_.surfaces, {new_volume_, new_transfer_});
    if (medium_.surfaces) medium_.ranges = majorants.ranges;
    if (params_.majorant_grid) medium_.majorants = majorants.majorants;
}

void VolumeGi::declare_cache(Graph& graph) {
    refine_ = graph.add_condition("refine the cache");
    const GuardScope guard = graph.when(refine_);
    cache_ = add_cache(graph, medium_, cache_params());
}

void VolumeGi::declare_picture(Graph& graph) {
    if (traces()) {
        const PathMode mode = caching()                          ? PathMode::gather
                              : params_.mode == VolumeMode::path ? PathMode::path
                                                                 : PathMode::noncaching;
        const PathTraceParams tracing{.width = params_.width,
            .height = params_.height,
            .mode = mode,
            .samples_per_step = params_.samples_per_step,
            .iterations = params_.iterations,
            .nee = params_.nee,
            .buffer_bytes = device_.limits().storage_bytes};
        const PathCache cache = cache_ ? PathCache{cache_->index, cache_->cells} : PathCache{};
        paths_ = add_path_trace(graph, medium_, tracing, {restart_, drain_}, cache);
        radiance_ = paths_.radiance;
        graph.omit_pass("compose", caching() ? "--gather on: paths begin at an exact collision"
                                             : "no cache to compose from");
        return;
    }
    graph.omit_pass("path_trace", "--gather off: the picture is composed from the cache");
    ComposeInputs in{.medium = medium_, .cache_index = cache_->index, .cache_cells = cache_->cells};
    if (medium_.surfaces && params_.search != SurfaceSearch::exact) {
        const SurfaceDepthParams search{.width = params_.width,
            .height = params_.height,
            .search = params_.search,
            .candidates = kDepthCandidates};
        in.surface_depth = add_surface_depth(graph, medium_, search, new_view_).depth;
    }
    const ComposeParams composing{
        .width = params_.width, .height = params_.height, .samples = params_.samples_per_step};
    composed_ = add_compose(graph, in, composing, restart_);
    radiance_ = composed_->picture;
}

void VolumeGi::declare_captures(Graph& graph) {
    captures_.clear();
    for (const std::string& name : params_.captures) {
        if (name == "surface_depth" && medium_.surfaces && !graph.find_image(name)) {
            const SurfaceDepthParams exact{.width = params_.width, .height = params_.height};
            add_surface_depth(graph, medium_, exact, new_view_);
        }
        const ImageHandle image = graph.find_image(name);
        if (!image) fail_input("--capture: this graph has no image '{}'; --plan lists them", name);
        if (image.resource != radiance_.resource) graph.export_resource(image, "--capture");
        captures_.push_back(image);
    }
}

void VolumeGi::bind() {
    gpu_.bind(*executor_, medium_.handles);
    executor_->bind(medium_.frame, frame_);
    if (meshes_) meshes_->bind(*executor_);
}

void VolumeGi::declare_anew() {
    if (caching()) cache_size_ = count_cache_cells(device_, gpu_, frame_, cache_params());
    executor_->update(declare());
    bind();
    pending_ = {};
}

void VolumeGi::execute(std::uint32_t steps) {
    check(steps == 1 || (steps > 1 && steps_together()), "one step, or as many as go together");
    if (pending_.cache != CacheChange::none) suspended_ = false;
    if (pending_.picture) progress_ = {.settled = suspended_ ? 1u : 0u};
    // Light from before the cache was finer must leave the mean: it begins anew after 1, 2, 4 ...
    // steps, so that half of them or more stay, and when the cache is done.
    const bool stale = caching() && !progress_.settled && !pending_.picture &&
                       (suspended_ || std::has_single_bit(progress_.steps));
    if (stale) {
        if (traces()) {
            const PathStatistics paths = path_statistics(executor_->read(paths_.statistics));
            progress_.paths += paths.finished;
            progress_.events += paths.steps;
            progress_.resumed += paths.resumed;
            progress_.truncated += paths.truncated + paths.clamped;
        }
        progress_.settled = suspended_ ? 1u : 0u;
    }
    executor_->set(new_volume_, pending_.volume);
    executor_->set(new_transfer_, pending_.volume || pending_.transfer);
    executor_->set(new_view_, pending_.picture);
    executor_->set(restart_, pending_.picture || stale);
    executor_->set(drain_, false);
    if (composed_) *composed_->begins = true;
    if (traces()) *paths_.samples = params_.samples_per_step * steps;
    const bool refines = !suspended_ && (refining_ || pending_.cache != CacheChange::none);
    if (cache_) {
        executor_->set(refine_, refines);
        set_cache_change(*executor_, *cache_, pending_.cache);
    }
    executor_->execute();
    pending_ = {false, false, false, CacheChange::none};
    progress_.steps += steps;
    if (cache_ && refines) suspended_ = cache_control().suspended != 0;
}

bool VolumeGi::finished() {
    if (pending_.picture || at_rest()) return true;
    if (traces()) return path_statistics(executor_->read(paths_.statistics)).drained();
    const Image counts = executor_->read(composed_->count);
    return std::ranges::all_of(
        counts.plane(0), [](float count) { return static_cast<std::uint32_t>(count) % 2 == 0; });
}

void VolumeGi::drain() {
    check(!pending_.picture, "drain() after a step");
    for (const Condition condition : {new_volume_, new_transfer_, new_view_, restart_})
        executor_->set(condition, false);
    executor_->set(drain_, true);
    if (composed_) *composed_->begins = false;
    if (cache_) executor_->set(refine_, false);
    executor_->execute();
}

void VolumeGi::finish() {
    while (!finished()) drain();
}

void VolumeGi::set_camera(const Camera& camera) {
    show(view_, camera);
    pending_.picture = true;
}

void VolumeGi::set_origin(glm::uvec2 origin) {
    origin_ = origin;
    set_camera(camera_);
}

void VolumeGi::set_view(const VolumeView& view) {
    refuse_search(view);
    shader::VolumeFrame before, after;
    std::memcpy(&before, frame_.mapped().data(), sizeof(before));
    const bool scattered = scatters(view_, params_.mode);
    const bool rested = at_rest();
    show(view, camera_);
    std::memcpy(&after, frame_.mapped().data(), sizeof(after));
    const CacheChange change = cache_change(before, after, params_.iso_occlusion);
    pending_.picture = true;
    pending_.cache = both(pending_.cache, change);
    const bool other_graph =
        (before.surface_count == 0) != (after.surface_count == 0) ||
        (caching() && (before.phase_g == 0) != (after.phase_g == 0)) ||
        (meshes_ &&
            (scatters(view_, params_.mode) != scattered || has_opaque(view_) != medium_.opaque ||
                has_translucent(view_) != medium_.translucent || at_rest() != rested));
    const bool other_size = cache_ && (change == CacheChange::medium ||
                                          (change == CacheChange::surface && !cache_->hold_solid));
    if (other_graph || other_size) declare_anew();
}

void VolumeGi::set_transfer(const TransferFunction& transfer) {
    const bool rested = at_rest();
    const bool other_facts = gpu_.set_transfer(transfer);
    show(view_, camera_);
    pending_.transfer = pending_.picture = true;
    pending_.cache = CacheChange::medium;
    if (other_facts || caching() || at_rest() != rested)
        declare_anew();
    else
        bind();
}

void VolumeGi::set_picture(std::uint32_t width, std::uint32_t height, bool gather) {
    VolumeGiParams params = params_;
    params.width = width;
    params.height = height;
    params.gather = gather;
    params_ = checked(params);
    show(view_, camera_);
    executor_->update(declare());
    bind();
    pending_.picture = true;
}

shader::CacheControl VolumeGi::cache_control() {
    shader::CacheControl control;
    const std::vector<std::byte> bytes = executor_->read(cache_->control);
    std::memcpy(&control, bytes.data(), sizeof(control));
    return control;
}

VolumeStatistics VolumeGi::statistics() {
    VolumeStatistics out;
    const glm::uvec3 cells = gpu_.facts().cells;
    out.majorant_cells = medium_.majorants ? std::uint64_t{cells.x} * cells.y * cells.z : 1;
    if (traces()) {
        const PathStatistics paths = path_statistics(executor_->read(paths_.statistics));
        out.paths = progress_.paths + paths.finished;
        out.steps = progress_.events + paths.steps;
        out.resumed = progress_.resumed + paths.resumed;
        out.truncated = progress_.truncated + paths.truncated + paths.clamped;
        add_pixel_error(out);
    }
    if (cache_) {
        const shader::CacheControl control = cache_control();
        out.paths += number_of(control.paths);
        out.steps += number_of(control.events);
        out.resumed += number_of(control.resumed);
        out.truncated += control.clamped;
        out.cells = cache_size_.slots;
        out.cell_bytes = cache_size_.bytes;
        out.cache_converged = control.suspended != 0;
    }
    return out;
}

void VolumeGi::add_pixel_error(VolumeStatistics& out) {
    const Image sum = executor_->read(paths_.sum), square = executor_->read(paths_.square);
    const std::vector<std::byte> bytes = executor_->read(paths_.progress);
    std::vector<glm::uvec2> progress(sum.pixels());
    std::memcpy(progress.data(), bytes.data(), progress.size() * sizeof(glm::uvec2));
    double variance = 0, mean = 0;
    for (std::size_t i = 0; i < sum.pixels(); ++i) {
        const double n = progress[i].x;
        if (n < 1) continue;
        const double m = luminance(sum, i) / n;
        mean += m;
        // Of one sample nothing is known: as if it were its own error.
        const double spread = n > 1 ? (square.plane(0)[i] / n - m * m) / (n - 1) : m * m;
        variance += std::max(spread, 0.0);
    }
    if (meshes_) { // the samples are of the change of their picture
        const Image picture = executor_->read(medium_.meshes.picture);
        for (std::size_t i = 0; i < picture.pixels(); ++i) mean += luminance(picture, i);
    }
    const auto pixels = static_cast<double>(sum.pixels());
    out.mean_variance = variance / pixels;
    out.relative_error = mean > 0 ? std::sqrt(*out.mean_variance) / (mean / pixels) : 0.0;
}

std::vector<SavedResource> VolumeGi::save() {
    check(!pending_.picture && pending_.cache == CacheChange::none, "save() after a step");
    std::vector<SavedResource> saved = executor_->save();
    const auto bytes = std::as_bytes(std::span(&progress_, 1));
    saved.push_back({kProgress, {bytes.begin(), bytes.end()}});
    return saved;
}

void VolumeGi::restore(std::vector<SavedResource> saved) {
    if (saved.empty() || saved.back().name != kProgress ||
        saved.back().bytes.size() != sizeof(progress_)) {
        fail_input("what was saved does not say how far the picture was");
    }
    std::memcpy(&progress_, saved.back().bytes.data(), sizeof(progress_));
    saved.pop_back();
    executor_->restore(saved);
    pending_ = {false, false, false, CacheChange::none};
    suspended_ = cache_ && cache_control().suspended != 0;
}

} // namespace ockham

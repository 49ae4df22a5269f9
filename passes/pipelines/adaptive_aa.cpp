// SPDX-License-Identifier: Apache-2.0
#include "passes/pipelines/adaptive_aa.hpp"

#include "framework/core/error.hpp"
#include "framework/core/log.hpp"
#include "framework/runtime/planning.hpp"
#include "passes/debug/surface_aov.hpp"
#include "passes/pipelines/aa_baselines.hpp"
#include "passes/post/taa.hpp"
#include "passes/schedule/coarsen.hpp"
#include "passes/surface/budget.hpp"
#include "passes/surface/cluster_counts.hpp"
#include "passes/surface/clusters.hpp"
#include "passes/surface/first_sample.hpp"
#include "passes/surface/metrics_ockham.hpp"
#include "passes/surface/resolve.hpp"
#include "passes/surface/shade.hpp"
#include "passes/surface/sraa.hpp"
#include "passes/surface/variance_history.hpp"

#include <algorithm>
#include <cstring>
#include <numeric>

namespace ockham {
namespace {

/// Where all samples are taken, their order says nothing.
std::vector<std::uint32_t> row_major_order(std::uint32_t m) {
    std::vector<std::uint32_t> order(m * m);
    std::iota(order.begin(), order.end(), 0u);
    return order;
}

/// Methods that filter pictures of one sample per pixel.
bool filters_picture(AaMethod method) {
    return method == AaMethod::fxaa || method == AaMethod::smaa || method == AaMethod::taa;
}

/// True where pixels differ in their counts, or in how these are shared out among surfaces.
bool needs_counts(const AdaptiveAaParams& params) {
    if (params.method == AaMethod::uniform)
        return params.resolve == Resolve::stratified && params.k > 1 &&
               params.k < params.m * params.m;
    return params.method == AaMethod::adaptive || params.method == AaMethod::msaa ||
           params.method == AaMethod::cluster;
}

/// The parameters with everything derived: m = 1 and "none" are the same picture.
AdaptiveAaParams settled(AdaptiveAaParams params) {
    if (params.width < 1 || params.height < 1 || params.width > 16384 || params.height > 16384) {
        fail_input(
            "picture of {} x {} pixels: each side must be 1 to 16384", params.width, params.height);
    }
    if (params.m < 1 || params.m > MAX_WINDOW) {
        fail_input("m = {}: the window must be 1 to {} samples wide", params.m, MAX_WINDOW);
    }
    if (params.method == AaMethod::none || filters_picture(params.method)) params.m = 1;
    if (params.method == AaMethod::msaa) {
        params.m = 2;
        params.resolve = Resolve::prefix; // one sample or all: nothing to share out
    }
    if (params.method == AaMethod::cluster) params.resolve = Resolve::stratified;
    const std::uint32_t n = params.m * params.m;
    if (params.method == AaMethod::ssaa) params.k = n;
    if (params.method == AaMethod::uniform && (params.k < 1 || params.k > n)) {
        fail_input(
            "k = {}: a window of {} x {} has 1 to {} samples", params.k, params.m, params.m, n);
    }
    if (params.count_block < 1 || params.count_block > 64) {
        fail_input("--k-filter max:{}: blocks are 1 to 64 pixels wide", params.count_block);
    }
    if (params.budget >= 0 && params.method == AaMethod::adaptive) {
        if (params.metric != MetricKind::ockham)
            fail_input("--budget: needs --metric ockham, which knows what a sample is worth");
        if (params.powers_of_two || params.count_block > 1)
            fail_input("--budget: --k-levels and --k-filter would exceed it; use one or the other");
    }
    if (n == 1 && !filters_picture(params.method)) params.method = AaMethod::none;
    if (params.order.empty()) {
        const bool partial = needs_counts(params) || params.method == AaMethod::sraa ||
                             (params.method == AaMethod::uniform && params.k < n);
        params.order = partial ? sample_order(params.order_kind, static_cast<int>(params.m))
                               : row_major_order(params.m);
    }
    return params;
}

void omit_adaptive_passes(Graph& graph, const std::string& reason) {
    for (const char* pass :
        {"clusters", "metrics", "variance_history", "allocate", "budget", "coarsen", "bucket_count",
            "bucket_scan", "bucket_arguments", "bucket_scatter", "tile_work", "tile_list"}) {
        graph.omit_pass(pass, reason);
    }
}

void omit_what_the_scene_lacks(Graph& graph, const SceneFacts& facts) {
    if (!facts.color_textures)
        graph.omit_resource("color_textures", "no material has a colour image");
    if (!facts.data_textures()) {
        graph.omit_resource(
            "data_textures", "no material has a normal, roughness or occlusion image");
    }
    if (!facts.masked) graph.omit_pass("gbuffer, masked draws", "no material has holes");
    if (!facts.sun_shadow) graph.omit_resource("shadow_map", "no directional light casts a shadow");
}

/// What needs to know the surfaces of each window; empty: nothing.
std::string clusters_reason(const AdaptiveAaParams& params) {
    if (params.method == AaMethod::msaa) return "--method msaa shades all samples of edges";
    if (!needs_counts(params)) return "";
    if (params.method == AaMethod::cluster) return "--method cluster shades each surface once";
    if (params.method == AaMethod::adaptive && params.metric == MetricKind::ockham)
        return "--metric ockham looks at surfaces apart";
    if (params.resolve == Resolve::stratified)
        return "--resolve stratified shares samples out among surfaces";
    return "";
}

/// k of methods that look at no colour.
ImageHandle add_surface_counts(Graph& graph, ImageHandle labels, const AdaptiveAaParams& params) {
    const std::uint32_t n = params.m * params.m;
    if (params.method == AaMethod::msaa) {
        return add_cluster_counts(graph, labels, {.samples = n, .single = 1, .several = n},
            "all samples where a pixel sees several surfaces");
    }
    if (params.method == AaMethod::cluster) {
        return add_cluster_counts(graph, labels, {.samples = n, .single = 1, .several = 0},
            "one sample for each surface that a pixel sees");
    }
    return add_cluster_counts(graph, labels,
        {.samples = n, .single = params.k, .several = params.k},
        "the same for all, to be shared out among surfaces");
}

/// k of every pixel, and what asked for it.
Allocation add_counts(Graph& graph, const ShadingInputs& in, const Clusters& clusters,
    ImageHandle first_sample, const AdaptiveAaParams& params) {
    if (params.method != AaMethod::adaptive) {
        for (const char* pass : {"metrics", "allocate", "budget"})
            graph.omit_pass(pass, "the method counts surfaces, if anything");
        return {add_surface_counts(graph, clusters.labels, params), {}};
    }
    if (params.metric == MetricKind::paper) {
        MetricsParams metrics = params.metrics;
        metrics.width = params.width;
        metrics.height = params.height;
        metrics.winner = params.aov;
        const Metrics counts =
            add_metrics(graph, {in.scene.frame, in.gbuffer, first_sample}, metrics);
        graph.omit_pass("allocate", "--metric paper counts samples itself");
        graph.omit_pass("variance_history", "--metric paper expects no variance");
        graph.omit_pass("budget", "--metric paper counts samples itself");
        return {counts.sample_count, counts.winner};
    }
    ImageHandle variance =
        add_ockham_metrics(graph, {in.scene.frame, in.gbuffer, clusters, first_sample},
            {.m = params.m, .stratified = params.resolve == Resolve::stratified});
    if (in.frame_before) {
        variance = add_variance_history(
            graph, {in.scene.frame, in.frame_before, variance, clusters.first_surface});
    } else {
        graph.omit_pass("variance_history", "the camera stays: nothing to remember");
    }
    if (params.budget >= 0) {
        graph.omit_pass("allocate", "--budget finds the price itself");
        return add_budget(graph, variance,
            {.samples = params.m * params.m, .percent = params.budget, .winner = params.aov});
    }
    graph.omit_pass("budget", "no --budget: the price of a sample is given");
    return add_allocate(graph, variance,
        {.samples = params.m * params.m, .lambda = params.lambda, .winner = params.aov});
}

/// The back end, with the passes that prepare it.
ImageHandle add_shade(Graph& graph, const ShadingInputs& in, const ShadingParams& shading,
    const AdaptiveInputs& counts, Dispatch dispatch) {
    const std::uint32_t width = shading.width, height = shading.height;
    const bool lists = dispatch == Dispatch::buckets || dispatch == Dispatch::sort;
    if (!lists) {
        for (const char* pass :
            {"bucket_count", "bucket_scan", "bucket_arguments", "bucket_scatter"})
            graph.omit_pass(pass, "no list of pixels by count: only --dispatch buckets and sort");
    }
    if (dispatch != Dispatch::repack) {
        for (const char* pass : {"tile_work", "tile_list"})
            graph.omit_pass(pass, "no list of tiles: only --dispatch repack");
    }
    Buckets buckets;
    if (lists) {
        buckets = add_buckets(graph, counts.sample_count, {width, height, shading.m * shading.m});
    }
    switch (dispatch) {
    case Dispatch::loop:
        break;
    case Dispatch::buckets:
        return add_shade_buckets(graph, in, shading, counts, buckets);
    case Dispatch::sort:
        return add_shade_sorted(graph, in, shading, counts, buckets);
    case Dispatch::repack:
        return add_shade_repacked(
            graph, in, shading, counts, add_tile_list(graph, counts.sample_count, width, height));
    case Dispatch::stencil:
        return add_shade_tested(graph, in, shading, counts, CountTest::stencil);
    case Dispatch::depth:
        return add_shade_tested(graph, in, shading, counts, CountTest::depth);
    }
    return add_shade_loop(graph, in, shading, counts);
}

AdaptiveAaOutputs add_picture(Graph& graph, const ShadingInputs& in, const ShadingParams& shading,
    const AdaptiveAaParams& params) {
    AdaptiveAaOutputs out;
    switch (params.method) {
    case AaMethod::none:
    case AaMethod::fxaa:
    case AaMethod::smaa:
    case AaMethod::taa:
        omit_adaptive_passes(graph, "one sample per pixel: nothing to decide");
        graph.omit_pass("shade", "one sample per pixel: first_sample is the picture");
        graph.omit_pass("resolve", "one sample per pixel: first_sample is the picture");
        out.radiance = out.first_sample = add_first_sample(graph, in, shading);
        if (params.method == AaMethod::fxaa)
            out.radiance = add_fxaa_picture(graph, out.first_sample);
        if (params.method == AaMethod::smaa)
            out.radiance = add_smaa_picture(graph, out.first_sample);
        if (params.method == AaMethod::taa)
            out.radiance = add_taa(graph, {in.scene.frame, in.gbuffer, out.first_sample});
        return out;
    case AaMethod::sraa: {
        const std::string reason = "--method sraa shades one sample of every pixel";
        omit_adaptive_passes(graph, reason);
        graph.omit_pass("shade", reason);
        graph.omit_pass("resolve", reason);
        out.first_sample = add_first_sample(graph, in, shading);
        out.radiance = add_sraa(graph, {in.scene.frame, in.gbuffer, out.first_sample});
        return out;
    }
    case AaMethod::uniform:
    case AaMethod::ssaa: {
        if (needs_counts(params)) break;
        const std::string reason =
            fmt::format("every pixel takes {} samples: nothing to decide", params.k);
        omit_adaptive_passes(graph, reason);
        graph.omit_pass("first_sample", reason);
        const ImageHandle sum = add_shade_uniform(graph, in, shading, params.k);
        out.radiance = add_resolve_uniform(graph, sum, params.k);
        return out;
    }
    case AaMethod::msaa:
    case AaMethod::cluster:
    case AaMethod::adaptive:
        break;
    }

    Clusters clusters;
    if (const std::string reason = clusters_reason(params); !reason.empty()) {
        clusters = add_clusters(
            graph, in.scene.frame, in.gbuffer, {params.width, params.height, params.m}, reason);
    } else {
        graph.omit_pass(
            "clusters", "--metric paper and --resolve prefix look at the window as a whole");
    }
    out.first_sample = add_first_sample(graph, in, shading);
    const Allocation counts = add_counts(graph, in, clusters, out.first_sample, params);
    out.sample_count = counts.sample_count;
    out.winner = counts.winner;
    if (params.powers_of_two || params.count_block > 1) {
        out.sample_count = add_coarsen(graph, out.sample_count,
            {params.width, params.height, params.m * params.m, params.count_block,
                params.powers_of_two});
    } else {
        graph.omit_pass("coarsen", "--k-levels all, no --k-filter: counts stay as they are");
    }
    const ImageHandle sum = add_shade(graph, in, shading,
        {.first_sample = out.first_sample,
            .sample_count = out.sample_count,
            .clusters = params.resolve == Resolve::stratified ? clusters.labels : ImageHandle{}},
        params.dispatch);
    out.radiance = add_resolve(graph, sum, out.first_sample, out.sample_count);
    return out;
}

} // namespace

bool is_shading_pass(std::string_view pass) {
    if (is_baseline_pass(pass)) return true;
    // "shade" and its further rounds "shade.1", ...; the passes of the lists.
    return pass == "clusters" || pass == "first_sample" || pass == "metrics" ||
           pass == "variance_history" || pass == "allocate" || pass.starts_with("budget") ||
           pass == "coarsen" || pass.starts_with("bucket_") || pass.starts_with("tile_") ||
           pass.starts_with("shade") || pass == "resolve";
}

AdaptiveAaOutputs add_adaptive_aa(
    Graph& graph, ShadingInputs in, const AdaptiveAaParams& wanted, std::uint32_t max_extent) {
    const AdaptiveAaParams params = settled(wanted);
    omit_what_the_scene_lacks(graph, in.scene.scene->facts());
    in.gbuffer = add_gbuffer(graph, in.scene,
        {.width = params.width,
            .height = params.height,
            .m = params.m,
            .layout = params.gbuffer.value_or(GbufferLayout::packed),
            .slopes = !clusters_reason(params).empty(),
            .tile = params.view},
        max_extent);
    const ShadingParams shading{.width = params.width,
        .height = params.height,
        .m = params.m,
        .stall = params.stall,
        .anisotropy = params.anisotropy};
    AdaptiveAaOutputs out = add_picture(graph, in, shading, params);
    graph.export_resource(out.radiance, "the picture");

    if (params.aov) {
        const SurfaceAov aov =
            add_surface_aov(graph, in.scene.frame, in.gbuffer, params.width, params.height);
        out.aov_surface = aov.surface;
        out.aov_material = aov.material;
        for (const ImageHandle image :
            {out.aov_surface, out.aov_material, out.winner, out.sample_count, out.first_sample}) {
            if (image && image.resource != out.radiance.resource)
                graph.export_resource(image, "--aov");
        }
    } else {
        graph.omit_pass("surface_aov", "no --aov");
        if (params.export_counts && out.sample_count) {
            graph.export_resource(out.sample_count, "statistics of the sample counts");
        }
    }
    for (const std::string& name : params.captures) {
        const ImageHandle image = graph.find_image(name);
        if (!image) fail_input("--capture: this graph has no image '{}'; --plan lists them", name);
        if (image.resource != out.radiance.resource) graph.export_resource(image, "--capture");
        out.captures.push_back(image);
    }
    return out;
}

namespace {

/// Pixels around each pixel that decide about it.
constexpr std::uint32_t kApron = 1;

/// Pixels that stay in one tile: the blocks of --k-filter, and the quads of 2 x 2 samples over
/// which alpha tests take derivatives.
std::uint32_t block_of(const AdaptiveAaParams& params) {
    return std::lcm(params.count_block, params.m % 2 == 0 ? 1u : 2u);
}

std::uint32_t apron_of(const AdaptiveAaParams& params) {
    const std::uint32_t block = block_of(params);
    return (kApron + block - 1) / block * block;
}

bool keeps_history(const AdaptiveAaParams& params) {
    return params.history && params.method == AaMethod::adaptive &&
           params.metric == MetricKind::ockham;
}

/// Why the picture cannot be put together of tiles; empty: it can.
std::string whole_picture_reason(const AdaptiveAaParams& params) {
    if (filters_picture(params.method)) return "its --method looks farther around than one pixel";
    if (params.method == AaMethod::taa) return "--method taa keeps pictures of earlier frames";
    if (keeps_history(params)) return "--history keeps variances of earlier frames";
    if (params.budget >= 0)
        return "--budget shares samples out over all pixels at once; use --lambda";
    if (!params.captures.empty()) return "--capture would show one tile";
    return "";
}

double mib(std::uint64_t bytes) { return static_cast<double>(bytes) / (1 << 20); }

} // namespace

AdaptiveAa::AdaptiveAa(
    gpu::Device& device, const LitScene& lit, const Camera& camera, const AdaptiveAaParams& params)
    : lit_(&lit), params_(settled(params)), max_extent_(device.limits().attachment_extent) {
    if (needs_counts(params_) && params_.dispatch == Dispatch::stencil &&
        !device.exports_stencil()) {
        fail_device("--dispatch stencil needs VK_EXT_shader_stencil_export, which '{}' lacks; "
                    "--dispatch depth does the same without it",
            device.info().name);
    }
    fit_ = choose_fit(device);
    const glm::uvec2 picture(params_.width, params_.height);
    tiles_ = place_tiles(picture, fit_.tile, apron_of(params_), block_of(params_));
    if (tiles_.size() > 1) view_ = std::make_unique<ScreenTile>();
    if (!fit_.reason.empty()) {
        log::warning("{}: {}", fit_.reason,
            view_ ? fmt::format("drawn in {} tiles of {} x {} pixels, --gbuffer visibility",
                        tiles_.size(), fit_.tile.x, fit_.tile.y)
                  : "--gbuffer visibility instead");
    }
    constexpr std::uint64_t kBytes = sizeof(shader::FrameData);
    frame_ = std::make_unique<gpu::Buffer>(device, gpu::BufferInfo{.bytes = kBytes,
                                                       .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                                                       .name = "frame",
                                                       .memory = gpu::MemoryUse::upload});
    set_camera(camera);
    if (keeps_history(params_)) {
        frame_before_ =
            std::make_unique<gpu::Buffer>(device, gpu::BufferInfo{.bytes = kBytes,
                                                      .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                                                      .name = "frame_before",
                                                      .memory = gpu::MemoryUse::upload});
        std::memcpy(frame_before_->mapped().data(), frame_->mapped().data(), kBytes);
    }
    Declared declared = declare(fit_);
    outputs_ = declared.outputs;
    kept_ = {outputs_.radiance};
    if (params_.aov || params_.export_counts) kept_.push_back(outputs_.sample_count);
    if (params_.aov) {
        kept_.insert(kept_.end(),
            {outputs_.first_sample, outputs_.winner, outputs_.aov_surface, outputs_.aov_material});
    }
    std::erase_if(kept_, [](ImageHandle image) { return !image; });
    Policy policy;
    const std::uint64_t budget = device.allocator().budget_bytes();
    const std::uint64_t used = device.allocator().bytes_used();
    if (budget > 0) policy.memory_budget_bytes = budget > used ? budget - used : 1;
    executor_ = std::make_unique<Executor>(device, std::move(declared.graph), policy);
    lit.gpu().bind(*executor_, declared.in.scene.handles);
    executor_->bind(declared.in.scene.frame, *frame_);
    if (frame_before_) executor_->bind(declared.in.frame_before, *frame_before_);
    if (declared.in.shadow_map) executor_->bind(declared.in.shadow_map, *lit.shadow_map());
}

AdaptiveAa::Declared AdaptiveAa::declare(const Fit& fit) const {
    Declared out;
    out.in.scene.scene = &lit_->gpu();
    out.in.scene.handles = lit_->gpu().import(out.graph);
    out.in.scene.frame = out.graph.import_buffer("frame", {sizeof(shader::FrameData)}, {});
    if (keeps_history(params_))
        out.in.frame_before =
            out.graph.import_buffer("frame_before", {sizeof(shader::FrameData)}, {});
    if (const gpu::Image* map = lit_->shadow_map()) {
        out.in.shadow_map = out.graph.import_image("shadow_map",
            {.format = map->info().format,
                .width = map->info().width,
                .height = map->info().height},
            state_of(Access::sampled, Stage::compute));
    }
    AdaptiveAaParams part = params_;
    part.width = fit.tile.x;
    part.height = fit.tile.y;
    part.gbuffer = fit.layout;
    part.view = view_.get();
    out.outputs = add_adaptive_aa(out.graph, out.in, part, max_extent_);
    return out;
}

AdaptiveAa::Fit AdaptiveAa::choose_fit(gpu::Device& device) const {
    const glm::uvec2 picture(params_.width, params_.height);
    if (params_.gbuffer == GbufferLayout::packed) return {GbufferLayout::packed, picture, {}};
    const bool cut = params_.tile.x > 0; // on request
    std::string reason;
    if (!params_.gbuffer && !cut) {
        reason = obstacle(device, {GbufferLayout::packed, picture, {}});
        if (reason.empty()) return {GbufferLayout::packed, picture, {}};
    }
    glm::uvec2 most = cut ? params_.tile : picture;
    most = glm::min(most, glm::uvec2(max_extent_ / params_.m));
    for (;;) {
        Fit fit{GbufferLayout::visibility, {}, reason};
        for (int axis = 0; axis < 2; ++axis) {
            fit.tile[axis] =
                tile_extent(picture[axis], most[axis], apron_of(params_), block_of(params_));
        }
        const std::string whole = whole_picture_reason(params_);
        if (fit.tile != picture && !whole.empty())
            fail_device("{}: screen tiles cannot help, for {}", reason, whole);
        if (fit.tile.x == 0 || fit.tile.y == 0)
            fail_device("{}: not even {} x {} pixels fit", reason, most.x, most.y);
        const std::string why = obstacle(device, fit);
        if (why.empty()) return fit;
        if (reason.empty()) reason = why;
        const int longer = fit.tile.x >= fit.tile.y ? 0 : 1;
        most = fit.tile;
        most[longer] = (most[longer] + 1) / 2;
    }
}

/// Why the G-buffer does not fit so; empty: it does.
std::string AdaptiveAa::obstacle(gpu::Device& device, const Fit& fit) const {
    const glm::uvec2 samples = params_.m * fit.tile;
    if (samples.x > max_extent_ || samples.y > max_extent_) {
        return fmt::format("{} x {} samples exceed the {} a side of this device", samples.x,
            samples.y, max_extent_);
    }
    const std::uint64_t budget = device.allocator().budget_bytes();
    const std::uint64_t used = device.allocator().bytes_used();
    const std::uint64_t free = budget > used ? budget - used : 0;
    Declared declared = declare(fit);
    const Plan plan = make_plan(device, declared.graph);
    const char* layout = fit.layout == GbufferLayout::packed ? "packed" : "visibility";
    if (budget > 0 && plan.bytes_peak > free) {
        return fmt::format("--gbuffer {}: {} x {} samples need {:.1f} MiB, of the memory budget "
                           "{:.1f} MiB are free",
            layout, samples.x, samples.y, mib(plan.bytes_peak), mib(free));
    }
    const std::uint64_t most = device.limits().allocation_bytes;
    for (const Heap& heap : plan.heaps) {
        if (heap.bytes > most) {
            return fmt::format("--gbuffer {}: {} x {} samples need {:.1f} MiB in one piece, this "
                               "device gives {:.1f}",
                layout, samples.x, samples.y, mib(heap.bytes), mib(most));
        }
    }
    return "";
}

void AdaptiveAa::set_camera(const Camera& camera) {
    whole_ = make_frame(lit_->scene(), lit_->gpu().bounds(), camera,
        static_cast<int>(params_.width), static_cast<int>(params_.height),
        static_cast<int>(params_.m), params_.order, LitScene::kShadowMapSize);
    aim(tiles_.front());
}

void AdaptiveAa::aim(const TilePlacement& tile) {
    shader::FrameData frame = whole_;
    if (params_.method == AaMethod::taa) set_jitter(frame, taa_jitter(executed_));
    if (view_) {
        frame.size = fit_.tile;
        frame.origin = tile.origin;
        *view_ = {tile.origin, frame.picture};
        // Viewports have limits too. Past them, the tile alone is projected; no driver can render
        // such a picture whole, so that nothing need equal it.
        if (std::max(frame.picture.x, frame.picture.y) * params_.m > max_extent_) {
            const glm::vec2 picture(frame.picture), size(frame.size), origin(frame.origin);
            glm::mat4 window(1.0f);
            for (int axis = 0; axis < 2; ++axis) {
                window[axis][axis] = picture[axis] / size[axis];
                window[3][axis] = (picture[axis] - 2.0f * origin[axis] - size[axis]) / size[axis];
            }
            frame.view_projection = window * frame.view_projection;
            *view_ = {{}, frame.size};
        }
    }
    std::memcpy(frame_->mapped().data(), &frame, sizeof(frame));
}

void AdaptiveAa::execute() {
    if (!view_) {
        aim(tiles_.front());
        executor_->execute();
        ++executed_;
        if (frame_before_) std::memcpy(frame_before_->mapped().data(), &whole_, sizeof(whole_));
        return;
    }
    times_.clear();
    for (const TilePlacement& tile : tiles_) {
        aim(tile);
        executor_->execute();
        const std::vector<PassTime>& times = executor_->times();
        if (times_.empty()) {
            times_ = times;
        } else {
            for (std::size_t i = 0; i < times.size(); ++i)
                times_[i].milliseconds += times[i].milliseconds;
        }
        for (const ImageHandle image : kept_) {
            paste_tile(pictures_[image.resource], executor_->read(image), tile,
                {params_.width, params_.height}, 1);
        }
    }
}

Image AdaptiveAa::read(ImageHandle image) {
    if (!view_) return executor_->read(image);
    const auto found = pictures_.find(image.resource);
    check(found != pictures_.end(), "only outputs are put together of tiles");
    return found->second;
}

AdaptiveAa::SampleCounts AdaptiveAa::sample_counts(std::uint32_t lanes) {
    const std::uint32_t n = params_.m * params_.m;
    const std::uint64_t pixels = std::uint64_t{params_.width} * params_.height;
    SampleCounts counts;
    counts.histogram.assign(n, 0);
    if (!needs_counts(params_)) {
        const bool counted =
            params_.method == AaMethod::uniform || params_.method == AaMethod::ssaa;
        const std::uint32_t k = counted ? params_.k : 1;
        counts.histogram[k - 1] = pixels;
        counts.mean = k;
        counts.percent = counts.shaded_percent = 100.0 * k / n;
        return counts;
    }
    check(bool(outputs_.sample_count) && (params_.export_counts || params_.aov),
        "counts were not exported");
    const Image map = read(outputs_.sample_count);
    const std::span<const float> k = map.plane(0);
    std::uint64_t sum = 0;
    for (const float value : k) {
        const auto count = static_cast<std::uint32_t>(value);
        check(count >= 1 && count <= n, "a pixel has 1 to n samples");
        ++counts.histogram[count - 1];
        sum += count;
    }
    const double all = static_cast<double>(pixels) * n;
    counts.percent = 100.0 * static_cast<double>(sum) / all;
    counts.mean = static_cast<double>(sum) / static_cast<double>(pixels);
    counts.lane_efficiency =
        ockham::lane_efficiency(k, params_.width, params_.height, params_.dispatch, lanes);
    counts.shaded_percent =
        counts.percent + 100.0 * static_cast<double>(counts.histogram[n - 1]) / all;
    return counts;
}

} // namespace ockham

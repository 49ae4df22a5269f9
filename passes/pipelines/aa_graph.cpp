// SPDX-License-Identifier: Apache-2.0
#include "passes/pipelines/aa_graph.hpp"

#include "framework/core/error.hpp"
#include "passes/debug/surface_aov.hpp"
#include "passes/pipelines/aa_baselines.hpp"
#include "passes/post/bloom.hpp"
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
#include "passes/surface/surface_means.hpp"
#include "passes/surface/variance_history.hpp"
#include "shaders/shared/frame.h"

#include <algorithm>
#include <numeric>

namespace ockham {
namespace {

/// Where all samples are taken, their order says nothing.
std::vector<std::uint32_t> row_major_order(std::uint32_t m) {
    std::vector<std::uint32_t> order(m * m);
    std::iota(order.begin(), order.end(), 0u);
    return order;
}

} // namespace

bool filters_picture(AaMethod method) {
    return method == AaMethod::fxaa || method == AaMethod::smaa || method == AaMethod::taa;
}

bool needs_counts(const AdaptiveAaParams& params) {
    if (params.method == AaMethod::uniform)
        return params.resolve == Resolve::stratified && params.k > 1 &&
               params.k < params.m * params.m;
    return params.method == AaMethod::adaptive || params.method == AaMethod::msaa ||
           params.method == AaMethod::cluster;
}

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
    if (!(params.bloom >= 0 && params.bloom <= 1))
        fail_input("--bloom {}: a share is 0 to 1", params.bloom);
    if (!(params.bloom_width > 0 && params.bloom_width <= 100))
        fail_input("--bloom-width {}: more than 0 and at most 100 percent", params.bloom_width);
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

namespace {

void omit_adaptive_passes(Graph& graph, const std::string& reason) {
    for (const char* pass : {"clusters", "surface_means", "first_luma", "metrics", "variance_pool",
             "variance_history", "allocate", "budget", "coarsen", "bucket_count", "bucket_scan",
             "bucket_arguments", "bucket_scatter", "tile_work", "tile_list"}) {
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
        for (const char* pass : {"first_luma", "metrics", "variance_pool", "allocate", "budget"})
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
        graph.omit_pass("first_luma", "--metric paper looks at four neighbours only");
        graph.omit_pass("variance_pool", "--metric paper expects no variance");
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

/// What samples take from all of their surface; sets the members of `in` that say so.
void add_means(
    Graph& graph, ShadingInputs& in, const Clusters& clusters, const AdaptiveAaParams& params) {
    const SceneFacts& facts = in.scene.scene->facts();
    const bool textured = facts.color_textures;
    const bool lights = facts.lights() > 0;
    const bool stratified = params.resolve == Resolve::stratified;
    in.demodulate = stratified && params.demodulate && textured;
    in.filter_highlights = stratified && params.filter_highlights && lights && facts.glossy;
    if (in.demodulate || in.filter_highlights) {
        in.means = add_surface_means(graph, in.scene, in.gbuffer, clusters,
            {.width = params.width,
                .height = params.height,
                .anisotropy = params.anisotropy,
                .albedo = in.demodulate});
    } else {
        graph.omit_pass("surface_means",
            !stratified
                ? "--resolve prefix knows no surfaces"
                : fmt::format("{}; {}",
                      params.demodulate ? "no material has a colour image" : "no --demodulate",
                      !params.filter_highlights ? "no --filter-highlights"
                      : !lights                 ? "ambient light makes no highlights"
                                                : "no material is smoother than roughness 1"));
    }
}

AdaptiveAaOutputs add_picture(
    Graph& graph, ShadingInputs in, const ShadingParams& shading, const AdaptiveAaParams& params) {
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
    out.labels = clusters.labels;
    add_means(graph, in, clusters, params);
    const ImageHandle labels =
        params.resolve == Resolve::stratified ? clusters.labels : ImageHandle{};
    out.first_sample = add_first_sample(graph, in, shading, labels);
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
        {.first_sample = out.first_sample, .sample_count = out.sample_count, .clusters = labels},
        params.dispatch);
    out.radiance = add_resolve(graph, sum, out.first_sample, out.sample_count);
    return out;
}

} // namespace

bool is_shading_pass(std::string_view pass) {
    if (is_baseline_pass(pass)) return true;
    // "shade" and its further rounds "shade.1", ...; the passes of the lists.
    return pass == "clusters" || pass == "surface_means" || pass == "first_sample" ||
           pass == "first_luma" || pass == "metrics" || pass == "variance_pool" ||
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
            .slopes = !clusters_reason(params).empty() || (in.medium && params.m > 1),
            .tile = params.view,
            .medium = in.medium && in.medium->opaque ? in.medium : std::nullopt},
        max_extent);
    const ShadingParams shading{.width = params.width,
        .height = params.height,
        .m = params.m,
        .stall = params.stall,
        .anisotropy = params.anisotropy};
    AdaptiveAaOutputs out = add_picture(graph, in, shading, params);
    out.gbuffer = in.gbuffer;
    if (params.bloom > 0) {
        out.radiance = add_bloom(graph, out.radiance,
            {.share = params.bloom,
                .sigma = params.bloom_width / 100 * static_cast<float>(params.height)});
    } else {
        graph.omit_pass("bloom", "no --bloom: the lens scatters no light");
    }
    if (in.medium && !out.labels && params.m > 1) {
        out.labels =
            add_clusters(graph, in.scene.frame, in.gbuffer, {params.width, params.height, params.m},
                "the medium hides each surface of a pixel for itself")
                .labels;
    }
    if (!in.medium) graph.export_resource(out.radiance, "the picture");
    if (!params.no_medium.empty()) {
        for (const char* pass :
            {"gbuffer, isosurfaces", "majorants", "cache", "path_trace", "compose", "over_meshes"})
            graph.omit_pass(pass, params.no_medium);
        for (const char* resource : {"volume", "transfer"})
            graph.omit_resource(resource, params.no_medium);
    }

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

} // namespace ockham

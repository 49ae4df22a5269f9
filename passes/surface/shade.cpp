// SPDX-License-Identifier: Apache-2.0
#include "passes/surface/shade.hpp"

#include "framework/core/error.hpp"
#include "shaders/schedule/buckets.h"
#include "shaders/surface/shade.h"

#include <algorithm>
#include <functional>

namespace ockham {
namespace {

/// What one back end does in each round.
struct BackEnd {
    std::string reason;
    bool raster = false;
    bool stratified = false; ///< asks for clusters
    std::uint32_t most = 1;  ///< samples of a pixel
    /// Names what it reads besides shaders/surface/shade_sample.glsl and its sums.
    std::function<void(PassBuilder&)> declare;
    /// Runs a variant of its shader on the samples push.first ... push.last - 1.
    std::function<void(Commands&, const std::string& features, shader::ShadePush push)> run;
};

/// Adds the passes that together sum all samples, each within the iteration budget.
ImageHandle add_rounds(
    Graph& graph, const ShadingInputs& in, const ShadingParams& params, const BackEnd& back_end) {
    const std::uint32_t per_round =
        samples_per_dispatch(in.scene.scene->facts(), params, in.medium);
    const Stage stage = back_end.raster ? Stage::fragment : Stage::compute;
    ImageHandle sum = graph.create_image("shaded_sum",
        {.format = VK_FORMAT_R32G32B32A32_SFLOAT, .width = params.width, .height = params.height});
    std::uint32_t round = 0;
    for (std::uint32_t first = 0; first < back_end.most; first += per_round, ++round) {
        const std::string name = round == 0 ? "shade" : fmt::format("shade.{}", round);
        PassBuilder pass =
            back_end.raster ? graph.add_raster_pass(name) : graph.add_compute_pass(name);
        pass.because(
            round == 0
                ? back_end.reason
                : fmt::format("continues the sums: at most {} samples fit one kernel", per_round));
        read_shading(pass, in, stage);
        back_end.declare(pass);
        sum = round == 0 ? pass.write("shaded_sum", sum, stage)
                         : pass.read_write("shaded_sum", sum, stage);
        const shader::ShadePush push{.count = back_end.most,
            .first = first,
            .last = std::min(first + per_round, back_end.most),
            .stall = params.stall,
            .anisotropy = static_cast<float>(params.anisotropy),
            .loop_bound = per_round};
        std::string features = back_end.stratified ? "stratified" : "";
        if (push.first > 0) features += features.empty() ? "continue" : ",continue";
        pass.record([features, push, run = back_end.run](
                        Commands& commands) { run(commands, features, push); });
    }
    return sum;
}

/// "surface/shade.comp:loop,continue,shadow": mode and features come before the scene's.
std::string variant(std::string_view shader, std::string mode, const std::string& features,
    const ShadingInputs& in) {
    if (!mode.empty() && !features.empty()) mode += ',';
    return shading_variant(shader, mode + features, in);
}

/// `shader` and `push` must outlive it.
ComputeCall kernel(const std::string& shader, const ShadingInputs& in, bool stratified,
    const shader::ShadePush& push) {
    return {.shader = shader,
        .specialization = shading_specialization(in, stratified),
        .push = as_push(push)};
}

void read_counts(PassBuilder& pass, const ShadingInputs& in, const AdaptiveInputs& counts,
    Stage stage = Stage::compute) {
    pass.read("first_sample", counts.first_sample, stage)
        .read("sample_count", counts.sample_count, stage);
    if (!counts.clusters) return;
    // Without means nothing reads them, but something must be bound.
    pass.sample("clusters", counts.clusters, stage)
        .sample("surface_means", in.means ? in.means : counts.clusters, stage);
}

/// Ranges of a list of pixels: those of one count each, or all as one.
ImageHandle add_shade_list(Graph& graph, const ShadingInputs& in, const ShadingParams& params,
    const AdaptiveInputs& counts, const Buckets& buckets, bool by_count, const char* reason) {
    const std::uint32_t n = params.m * params.m;
    return add_rounds(graph, in, params,
        {.reason = reason,
            .stratified = bool(counts.clusters),
            .most = n,
            .declare =
                [=](PassBuilder& pass) {
                    read_counts(pass, in, counts);
                    pass.read("bucket_table", buckets.table)
                        .read("pixel_list", buckets.list)
                        .indirect(buckets.arguments);
                },
            .run =
                [=](Commands& commands, const std::string& features, shader::ShadePush push) {
                    const std::string shader = variant("surface/shade.comp", "list", features, in);
                    // The dearest pixels first: what is left over at the end is then cheap. Counts
                    // up to push.first were done in earlier rounds.
                    const std::uint32_t most = by_count ? n : n + 1;
                    const std::uint32_t least = by_count ? std::max(2u, push.first + 1) : n + 1;
                    for (push.count = most; push.count >= least; --push.count) {
                        commands.dispatch_indirect(kernel(shader, in, bool(counts.clusters), push),
                            buckets.arguments,
                            (push.count - 1) * sizeof(shader::DispatchArguments));
                    }
                }});
}

} // namespace

ImageHandle add_shade_uniform(
    Graph& graph, const ShadingInputs& in, const ShadingParams& params, std::uint32_t k) {
    check(k >= 1 && k <= params.m * params.m, "k lies in 1 ... m * m");
    return add_rounds(graph, in, params,
        {.reason = fmt::format("{} samples for every pixel", k),
            .most = k,
            .declare = [](PassBuilder&) {},
            .run =
                [=](Commands& commands, const std::string& features, shader::ShadePush push) {
                    const std::string shader =
                        variant("surface/shade.comp", "uniform", features, in);
                    commands.dispatch_over(
                        kernel(shader, in, false, push), {params.width, params.height, 1});
                }});
}

ImageHandle add_shade_loop(Graph& graph, const ShadingInputs& in, const ShadingParams& params,
    const AdaptiveInputs& counts) {
    return add_rounds(graph, in, params,
        {.reason = "shades as many samples as each pixel's count says",
            .stratified = bool(counts.clusters),
            .most = params.m * params.m,
            .declare = [=](PassBuilder& pass) { read_counts(pass, in, counts); },
            .run =
                [=](Commands& commands, const std::string& features, shader::ShadePush push) {
                    const std::string shader = variant("surface/shade.comp", "loop", features, in);
                    commands.dispatch_over(kernel(shader, in, bool(counts.clusters), push),
                        {params.width, params.height, 1});
                }});
}

ImageHandle add_shade_buckets(Graph& graph, const ShadingInputs& in, const ShadingParams& params,
    const AdaptiveInputs& counts, const Buckets& buckets) {
    return add_shade_list(graph, in, params, counts, buckets, true,
        "shades the pixels of each count together, one dispatch per count");
}

ImageHandle add_shade_sorted(Graph& graph, const ShadingInputs& in, const ShadingParams& params,
    const AdaptiveInputs& counts, const Buckets& buckets) {
    return add_shade_list(graph, in, params, counts, buckets, false,
        "shades the pixels sorted by count, in one dispatch");
}

ImageHandle add_shade_repacked(Graph& graph, const ShadingInputs& in, const ShadingParams& params,
    const AdaptiveInputs& counts, const TileList& tiles) {
    return add_rounds(graph, in, params,
        {.reason = "spreads the samples of each tile over all lanes, whoever's pixel they are of",
            .stratified = bool(counts.clusters),
            .most = params.m * params.m,
            .declare =
                [=](PassBuilder& pass) {
                    read_counts(pass, in, counts);
                    pass.read("tile_list", tiles.list).indirect(tiles.arguments);
                },
            .run =
                [=](Commands& commands, const std::string& features, shader::ShadePush push) {
                    const std::string shader =
                        variant("surface/shade_repack.comp", "", features, in);
                    commands.dispatch_indirect(
                        kernel(shader, in, bool(counts.clusters), push), tiles.arguments, 0);
                }});
}

ImageHandle add_shade_tested(Graph& graph, const ShadingInputs& in, const ShadingParams& params,
    const AdaptiveInputs& counts, CountTest test) {
    const bool stencil = test == CountTest::stencil;
    ImageHandle target = graph.create_image(stencil ? "count_stencil" : "count_depth",
        {.format = stencil ? VK_FORMAT_S8_UINT : VK_FORMAT_D32_SFLOAT,
            .width = params.width,
            .height = params.height});
    const auto declare = [=](PassBuilder& pass) mutable {
        read_counts(pass, in, counts, Stage::fragment);
        // Each round writes it by its first draw and tests it in the others.
        target = stencil ? pass.stencil(target, 0) : pass.depth(target, 0.0f);
    };
    const auto run = [=](Commands& commands, const std::string& features, shader::ShadePush push) {
        constexpr const char* kPlane = "schedule/count_plane.vert";
        commands.bind({.vertex_shader = kPlane,
            .fragment_shader =
                stencil ? "schedule/count_target.frag:stencil" : "schedule/count_target.frag",
            .depth_test = !stencil,
            .depth_write = !stencil,
            .stencil_write = stencil});
        commands.push(as_push(push));
        commands.draw(3);
        const std::string shader = variant("surface/shade.frag", "", features, in);
        commands.bind({.vertex_shader = kPlane,
            .fragment_shader = shader,
            .specialization = shading_specialization(in, bool(counts.clusters)),
            .depth_test = !stencil,
            .depth_write = false,
            .depth_equal = !stencil,
            .stencil_equal = stencil});
        for (push.count = params.m * params.m; push.count >= std::max(2u, push.first + 1);
             --push.count) {
            commands.set_stencil(static_cast<std::uint8_t>(push.count));
            commands.push(as_push(push));
            commands.draw(3);
        }
    };
    return add_rounds(graph, in, params,
        {.reason = fmt::format("draws once per count, {} test stops the pixels of other counts",
             stencil ? "the stencil" : "the depth"),
            .raster = true,
            .stratified = bool(counts.clusters),
            .most = params.m * params.m,
            .declare = declare,
            .run = run});
}

} // namespace ockham

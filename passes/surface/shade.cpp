// SPDX-License-Identifier: Apache-2.0
#include "passes/surface/shade.hpp"

#include "framework/core/error.hpp"
#include "shaders/schedule/buckets.h"
#include "shaders/surface/shade.h"

#include <algorithm>
#include <functional>

namespace ockham {
namespace {

std::string shade_variant(
    std::string mode, const shader::ShadePush& push, const ShadingInputs& in) {
    if (push.first > 0) mode += ",continue";
    return shading_variant("surface/shade.comp", mode, in);
}

/// Adds the passes that together sum samples 0 ... most-1, each within the iteration budget.
/// `declare` names what the mode reads; `dispatch` runs one round.
ImageHandle add_rounds(Graph& graph, const ShadingInputs& in, const ShadingParams& params,
    std::uint32_t most, const std::string& reason, const std::function<void(PassBuilder&)>& declare,
    const std::function<void(Commands&, const shader::ShadePush&)>& dispatch) {
    const std::uint32_t per_round = samples_per_dispatch(in.scene.scene->facts(), params);
    ImageHandle sum = graph.create_image("shaded_sum",
        {.format = VK_FORMAT_R32G32B32A32_SFLOAT, .width = params.width, .height = params.height});
    std::uint32_t round = 0;
    for (std::uint32_t first = 0; first < most; first += per_round, ++round) {
        PassBuilder pass =
            graph.add_compute_pass(round == 0 ? "shade" : fmt::format("shade.{}", round));
        pass.because(
            round == 0
                ? reason
                : fmt::format("continues the sums: at most {} samples fit one kernel", per_round));
        read_shading(pass, in);
        declare(pass);
        sum = round == 0 ? pass.write("shaded_sum", sum) : pass.read_write("shaded_sum", sum);
        pass.record([=, last = std::min(first + per_round, most)](Commands& commands) {
            dispatch(commands, {.count = most,
                                   .first = first,
                                   .last = last,
                                   .stall = params.stall,
                                   .anisotropy = static_cast<float>(params.anisotropy),
                                   .loop_bound = per_round});
        });
    }
    return sum;
}

} // namespace

ImageHandle add_shade_uniform(
    Graph& graph, const ShadingInputs& in, const ShadingParams& params, std::uint32_t k) {
    check(k >= 1 && k <= params.m * params.m, "k lies in 1 ... m * m");
    return add_rounds(
        graph, in, params, k, fmt::format("{} samples for every pixel", k), [](PassBuilder&) {},
        [in, params](Commands& commands, const shader::ShadePush& push) {
            const std::string shader = shade_variant("uniform", push, in);
            commands.dispatch_over(
                {.shader = shader,
                    .specialization = light_specialization(in.scene.scene->facts()),
                    .push = as_push(push)},
                {params.width, params.height, 1});
        });
}

ImageHandle add_shade_loop(Graph& graph, const ShadingInputs& in, const ShadingParams& params,
    ImageHandle first_sample, ImageHandle sample_count) {
    return add_rounds(
        graph, in, params, params.m * params.m, "shades as many samples as each pixel's count says",
        [=](PassBuilder& pass) {
            pass.read("first_sample", first_sample).read("sample_count", sample_count);
        },
        [in, params](Commands& commands, const shader::ShadePush& push) {
            const std::string shader = shade_variant("loop", push, in);
            commands.dispatch_over(
                {.shader = shader,
                    .specialization = light_specialization(in.scene.scene->facts()),
                    .push = as_push(push)},
                {params.width, params.height, 1});
        });
}

ImageHandle add_shade_buckets(Graph& graph, const ShadingInputs& in, const ShadingParams& params,
    ImageHandle first_sample, const Buckets& buckets) {
    return add_rounds(
        graph, in, params, params.m * params.m, "shades the pixels of each count together",
        [=](PassBuilder& pass) {
            pass.read("first_sample", first_sample)
                .read("bucket_table", buckets.table)
                .read("pixel_list", buckets.list)
                .indirect(buckets.arguments);
        },
        [in, buckets](Commands& commands, shader::ShadePush push) {
            const std::string shader = shade_variant("buckets", push, in);
            const std::uint32_t n = push.count;
            // The dearest pixels first: what is left over at the end of a dispatch is then cheap.
            for (push.count = n; push.count >= 2; --push.count) {
                if (push.count <= push.first) break; // done in an earlier round
                commands.dispatch_indirect(
                    {.shader = shader,
                        .specialization = light_specialization(in.scene.scene->facts()),
                        .push = as_push(push)},
                    buckets.arguments, (push.count - 1) * sizeof(shader::DispatchArguments));
            }
        });
}

} // namespace ockham

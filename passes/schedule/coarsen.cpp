// SPDX-License-Identifier: Apache-2.0
#include "passes/schedule/coarsen.hpp"

#include "framework/core/error.hpp"
#include "framework/runtime/commands.hpp"
#include "shaders/schedule/coarsen.h"

namespace ockham {

ImageHandle add_coarsen(Graph& graph, ImageHandle sample_count, const CoarsenParams& params) {
    check(params.block >= 1 && params.block <= 64, "blocks of 1 to 64 pixels");
    const shader::CoarsenPush push{.size = {params.width, params.height},
        .block = params.block,
        .powers_of_two = params.powers_of_two,
        .n = params.n};
    const ImageHandle coarse = graph.create_image("coarse_count", graph.desc(sample_count));
    PassBuilder pass = graph.add_compute_pass("coarsen");
    pass.because(fmt::format("{}{}{}",
        params.block > 1 ? fmt::format("{0} x {0} pixels share their largest count", params.block)
                         : "",
        params.block > 1 && params.powers_of_two ? "; " : "",
        params.powers_of_two ? "counts are rounded up to powers of two" : ""));
    pass.read("fine_count", sample_count);
    const ImageHandle out = pass.write("sample_count", coarse);
    pass.record([push](Commands& commands) {
        const glm::uvec2 blocks = (push.size + push.block - 1u) / push.block;
        commands.dispatch_over(
            {.shader = "schedule/coarsen.comp", .specialization = {}, .push = as_push(push)},
            {blocks.x, blocks.y, 1});
    });
    return out;
}

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
#include "passes/surface/allocate.hpp"

#include "framework/core/error.hpp"
#include "framework/runtime/commands.hpp"
#include "passes/shader_variant.hpp"
#include "shaders/surface/allocate.h"

namespace ockham {

Allocation add_allocate(Graph& graph, ImageHandle variance, const AllocateParams& params) {
    ImageDesc counts = graph.desc(variance);
    counts.format = VK_FORMAT_R8_UINT;
    Allocation out{.sample_count = graph.create_image("sample_count", counts), .winner = {}};
    if (params.winner) out.winner = graph.create_image("winner", counts);

    PassBuilder pass = graph.add_compute_pass("allocate");
    pass.because(fmt::format("the samples that are worth lambda = {}", params.lambda));
    pass.read("variance", variance);
    out.sample_count = pass.write("sample_count", out.sample_count);
    if (params.winner) out.winner = pass.write("winner", out.winner);
    pass.record([counts, params](Commands& commands) {
        const shader::AllocatePush push{.size = {counts.width, counts.height},
            .samples = params.samples,
            .lambda = params.lambda};
        const std::string shader =
            shader_variant("surface/allocate.comp", {{"winner", params.winner}});
        commands.dispatch_over({.shader = shader, .specialization = {}, .push = as_push(push)},
            {counts.width, counts.height, 1});
    });
    return out;
}

} // namespace ockham

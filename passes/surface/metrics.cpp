// SPDX-License-Identifier: Apache-2.0
#include "passes/surface/metrics.hpp"

#include "framework/runtime/commands.hpp"
#include "passes/shader_variant.hpp"
#include "shaders/surface/metrics.h"

namespace ockham {

MetricsParams default_metrics(std::uint32_t m) {
    const auto width = static_cast<float>(m);
    MetricsParams params;
    params.depth_weight = 15.0f * width;
    params.normal_weight = 3.0f * width;
    params.shading_weight = 10.0f * width;
    return params;
}

Metrics add_metrics(Graph& graph, const MetricsInputs& in, const MetricsParams& params) {
    const ImageDesc counts{
        .format = VK_FORMAT_R8_UINT, .width = params.width, .height = params.height};
    Metrics out{.sample_count = graph.create_image("sample_count", counts), .winner = {}};
    if (params.winner) out.winner = graph.create_image("winner", counts);

    PassBuilder pass = graph.add_compute_pass("metrics");
    pass.because("decides how many samples each pixel deserves");
    pass.read("frame", in.frame)
        .sample("gbuffer", in.gbuffer.surface)
        .sample("gbuffer_depth", in.gbuffer.depth)
        .sample("first_sample", in.first_sample);
    out.sample_count = pass.write("sample_count", out.sample_count);
    if (params.winner) out.winner = pass.write("winner", out.winner);
    pass.record([params](Commands& commands) {
        const shader::MetricsPush push{params.depth_weight, params.normal_weight,
            params.shading_weight, params.range_min, params.range_edge};
        const std::string shader =
            shader_variant("surface/metrics.comp", {{"winner", params.winner}});
        commands.dispatch_over({.shader = shader, .specialization = {}, .push = as_push(push)},
            {params.width, params.height, 1});
    });
    return out;
}

} // namespace ockham

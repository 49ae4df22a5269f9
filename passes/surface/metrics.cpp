// SPDX-License-Identifier: Apache-2.0
#include "passes/surface/metrics.hpp"

#include "framework/runtime/commands.hpp"
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
    read_gbuffer(pass, in.gbuffer);
    pass.uniform("frame", in.frame).sample("first_sample", in.first_sample);
    out.sample_count = pass.write("sample_count", out.sample_count);
    if (params.winner) out.winner = pass.write("winner", out.winner);
    pass.record([params, gbuffer = in.gbuffer](Commands& commands) {
        const shader::MetricsPush push{params.depth_weight, params.normal_weight,
            params.shading_weight, params.range_min, params.range_edge};
        const std::string shader =
            gbuffer_variant("surface/metrics.comp", params.winner ? "winner" : "", gbuffer);
        commands.dispatch_over({.shader = shader,
                                   .specialization = gbuffer_specialization(gbuffer),
                                   .push = as_push(push)},
            {params.width, params.height, 1});
    });
    return out;
}

} // namespace ockham

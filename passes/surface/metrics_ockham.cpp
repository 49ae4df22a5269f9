// SPDX-License-Identifier: Apache-2.0
#include "passes/surface/metrics_ockham.hpp"

#include "framework/runtime/commands.hpp"
#include "shaders/surface/metrics.h"

namespace ockham {

ImageHandle add_ockham_metrics(
    Graph& graph, const OckhamMetricsInputs& in, const OckhamMetricsParams& params) {
    ImageDesc desc = graph.desc(in.first_sample);
    desc.format = VK_FORMAT_R32G32_SFLOAT;
    PassBuilder pass = graph.add_compute_pass("metrics");
    pass.because("how much the colours of each pixel are expected to vary");
    pass.read("frame", in.frame);
    read_gbuffer(pass, in.gbuffer);
    pass.sample("clusters", in.clusters.labels)
        .sample("normal_spread", in.clusters.normal_spread)
        .sample("first_surface", in.clusters.first_surface)
        .sample("first_sample", in.first_sample);
    const ImageHandle lone = pass.write("lone_variance", graph.create_image("lone_variance", desc));
    pass.record([desc, params, gbuffer = in.gbuffer](Commands& commands) {
        const shader::OckhamMetricsPush push{.stratified = params.stratified ? 1u : 0u};
        const std::string shader = gbuffer_variant(
            "surface/metrics_ockham.comp", params.m * params.m > 16 ? "wide" : "", gbuffer);
        commands.dispatch_over({.shader = shader,
                                   .specialization = gbuffer_specialization(gbuffer),
                                   .push = as_push(push)},
            {desc.width, desc.height, 1});
    });

    PassBuilder pool = graph.add_compute_pass("variance_pool");
    pool.because("where the neighbours vary, so does the pixel");
    pool.sample("lone_variance", lone);
    const ImageHandle out = pool.write("variance", graph.create_image("variance", desc));
    pool.record([desc](Commands& commands) {
        const shader::VariancePoolPush push{.size = {desc.width, desc.height}};
        commands.dispatch_over(
            {.shader = "surface/variance_pool.comp", .specialization = {}, .push = as_push(push)},
            {desc.width, desc.height, 1});
    });
    return out;
}

} // namespace ockham

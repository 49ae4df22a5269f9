// SPDX-License-Identifier: Apache-2.0
#include "passes/surface/metrics_ockham.hpp"

#include "framework/runtime/commands.hpp"
#include "shaders/surface/metrics.h"

namespace ockham {

ImageHandle add_ockham_metrics(
    Graph& graph, const OckhamMetricsInputs& in, const OckhamMetricsParams& params) {
    ImageDesc desc = graph.desc(in.first_sample);
    const shader::PictureSizePush size{{desc.width, desc.height}};
    const auto over_picture = [desc, size](const char* shader) {
        return [desc, size, shader](Commands& commands) {
            commands.dispatch_over({.shader = shader, .specialization = {}, .push = as_push(size)},
                {desc.width, desc.height, 1});
        };
    };
    PassBuilder lumas = graph.add_compute_pass("first_luma");
    lumas.because("each pixel's luma is asked for by all around it");
    lumas.sample("first_sample", in.first_sample);
    desc.format = VK_FORMAT_R32_SFLOAT;
    const ImageHandle luma = lumas.write("first_luma", graph.create_image("first_luma", desc));
    lumas.record(over_picture("surface/first_luma.comp"));

    desc.format = VK_FORMAT_R32G32_SFLOAT;
    PassBuilder pass = graph.add_compute_pass("metrics");
    pass.because("how much the colours of each pixel are expected to vary");
    pass.uniform("frame", in.frame);
    read_gbuffer(pass, in.gbuffer);
    pass.read("clusters", in.clusters.labels)
        .read("normal_spread", in.clusters.normal_spread)
        .read("first_surface", in.clusters.first_surface)
        .read("first_luma", luma);
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
    pool.read("lone_variance", lone);
    const ImageHandle out = pool.write("variance", graph.create_image("variance", desc));
    pool.record(over_picture("surface/variance_pool.comp"));
    return out;
}

} // namespace ockham

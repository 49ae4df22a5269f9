// SPDX-License-Identifier: Apache-2.0
#include "passes/surface/clusters.hpp"

#include "framework/core/error.hpp"
#include "framework/runtime/commands.hpp"

namespace ockham {

Clusters add_clusters(Graph& graph, BufferHandle frame, const Gbuffer& gbuffer,
    const ClustersParams& params, const std::string& reason) {
    check(gbuffer.layout == GbufferLayout::visibility || bool(gbuffer.slopes),
        "planes need the G-buffer's slopes");
    const bool wide = params.m * params.m > 16;
    const auto create = [&](const char* name, VkFormat format) {
        return graph.create_image(
            name, {.format = format, .width = params.width, .height = params.height});
    };
    Clusters out{
        .labels = create("clusters", wide ? VK_FORMAT_R32G32B32A32_UINT : VK_FORMAT_R32_UINT),
        .normal_spread = create("normal_spread", VK_FORMAT_R8G8B8A8_UNORM),
        .first_surface = create("first_surface", VK_FORMAT_R32G32_UINT),
    };
    PassBuilder pass = graph.add_compute_pass("clusters");
    pass.because(reason);
    pass.uniform("frame", frame);
    read_gbuffer(pass, gbuffer);
    out.labels = pass.write("clusters", out.labels);
    out.normal_spread = pass.write("normal_spread", out.normal_spread);
    out.first_surface = pass.write("first_surface", out.first_surface);
    pass.record([params, gbuffer, wide](Commands& commands) {
        const std::string shader =
            gbuffer_variant("surface/clusters.comp", wide ? "wide" : "", gbuffer);
        commands.dispatch_over(
            {.shader = shader, .specialization = gbuffer_specialization(gbuffer), .push = {}},
            {params.width, params.height, 1});
    });
    return out;
}

} // namespace ockham

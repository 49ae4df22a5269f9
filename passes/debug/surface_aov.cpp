// SPDX-License-Identifier: Apache-2.0
#include "passes/debug/surface_aov.hpp"

#include "framework/runtime/commands.hpp"

namespace ockham {

SurfaceAov add_surface_aov(Graph& graph, BufferHandle frame, const Gbuffer& gbuffer,
    std::uint32_t width, std::uint32_t height) {
    SurfaceAov out{
        .surface = graph.create_image("aov_surface",
            {.format = VK_FORMAT_R32G32B32A32_SFLOAT, .width = width, .height = height}),
        .material = graph.create_image(
            "aov_material", {.format = VK_FORMAT_R32_UINT, .width = width, .height = height}),
    };
    PassBuilder pass = graph.add_compute_pass("surface_aov");
    pass.because("depth, normal and material were asked for as pictures");
    read_gbuffer(pass, gbuffer);
    pass.uniform("frame", frame);
    out.surface = pass.write("aov_surface", out.surface);
    out.material = pass.write("aov_material", out.material);
    pass.record([gbuffer, width, height](Commands& commands) {
        const std::string shader = gbuffer_variant("debug/surface_aov.comp", "", gbuffer);
        commands.dispatch_over(
            {.shader = shader, .specialization = gbuffer_specialization(gbuffer), .push = {}},
            {width, height, 1});
    });
    return out;
}

} // namespace ockham

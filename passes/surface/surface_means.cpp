// SPDX-License-Identifier: Apache-2.0
#include "passes/surface/surface_means.hpp"

#include "framework/runtime/commands.hpp"
#include "passes/shader_variant.hpp"
#include "shaders/surface/shade.h"

namespace ockham {

ImageHandle add_surface_means(Graph& graph, const SceneInputs& scene, const Gbuffer& gbuffer,
    const Clusters& clusters, const SurfaceMeansParams& params) {
    PassBuilder pass = graph.add_compute_pass("surface_means");
    pass.because(params.albedo ? "samples have the mean colour of the surface that they stand for"
                               : "highlights hold the normals of the surface that they stand for");
    read_gbuffer(pass, gbuffer);
    pass.uniform("frame", scene.frame)
        .sample("clusters", clusters.labels)
        .sample("normal_spread", clusters.normal_spread);
    const bool packed = gbuffer.layout == GbufferLayout::packed;
    if (packed) pass.read("materials", scene.handles.materials);
    if (params.albedo) {
        pass.sample(
            "color_textures", scene.handles.color_textures, Stage::compute, Filter::linear_repeat);
    }
    const VkFormat format = params.albedo ? VK_FORMAT_R32G32B32A32_UINT : VK_FORMAT_R32_UINT;
    const ImageHandle out = pass.write(
        "surface_means", graph.create_image("surface_means",
                             {.format = format, .width = params.width, .height = params.height}));
    pass.record([params, gbuffer](Commands& commands) {
        const std::string mode =
            shader_variant("", {{"color_textures", params.albedo}, {"extra", bool(gbuffer.extra)}});
        Specialization specialization = gbuffer_specialization(gbuffer);
        specialization.emplace_back(SPEC_DEMODULATE, params.albedo);
        const shader::SurfaceMeansPush push{static_cast<float>(params.anisotropy)};
        commands.dispatch_over({.shader = gbuffer_variant("surface/surface_means.comp",
                                    mode.empty() ? mode : mode.substr(1), gbuffer),
                                   .specialization = specialization,
                                   .push = as_push(push)},
            {params.width, params.height, 1});
    });
    return out;
}

} // namespace ockham

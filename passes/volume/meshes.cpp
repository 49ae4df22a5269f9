// SPDX-License-Identifier: Apache-2.0
#include "passes/volume/meshes.hpp"

#include "framework/core/error.hpp"
#include "framework/runtime/commands.hpp"
#include "shaders/surface/shade.h"
#include "shaders/volume/meshes.h"

namespace ockham {
namespace {

constexpr std::uint32_t kMaxClusters = 4; // shaders/surface/clusters.glsl

} // namespace

ImageHandle add_mesh_ends(Graph& graph, BufferHandle frame, const Gbuffer& gbuffer,
    ImageHandle labels, const ShadingParams& params) {
    check(gbuffer.layout == GbufferLayout::packed, "rays end on packed samples");
    const glm::uvec2 samples = params.m * glm::uvec2(params.width, params.height);
    const ImageHandle image = graph.create_persistent_image(
        "mesh_ends", {.format = VK_FORMAT_R32_UINT, .width = samples.x, .height = samples.y});
    PassBuilder pass = graph.add_compute_pass("mesh_ends");
    pass.because("meshes end the camera's rays through the medium");
    pass.uniform("frame", frame);
    read_gbuffer(pass, gbuffer, Stage::compute);
    if (labels) pass.sample("clusters", labels);
    const ImageHandle out = pass.write("mesh_ends", image);
    const char* shader = labels ? "volume/mesh_ends.comp:labels" : "volume/mesh_ends.comp";
    pass.record([samples, shader](Commands& commands) {
        commands.dispatch_over({.shader = shader}, {samples.x, samples.y, 1});
    });
    return out;
}

ImageHandle add_mesh_radiance(Graph& graph, const ShadingInputs& in, ImageHandle labels,
    ImageHandle picture, const ShadingParams& params) {
    samples_per_dispatch(in.scene.scene->facts(), params, in.medium); // refuses what is too much
    ImageDesc desc = graph.desc(picture);
    desc.layers = kMaxClusters;
    const ImageHandle image = graph.create_persistent_image("mesh_radiance", desc);
    PassBuilder pass = graph.add_compute_pass("mesh_radiance");
    pass.because("the medium hides each surface of a pixel for itself");
    read_shading(pass, in);
    pass.read("meshes", picture).sample("clusters", labels);
    const ImageHandle out = pass.write("mesh_radiance", image);
    pass.record([in, params](Commands& commands) {
        const shader::ShadePush push = one_sample_push(params);
        const std::string shader = shading_variant("surface/mesh_radiance.comp", "", in);
        commands.dispatch_over(
            {.shader = shader, .specialization = shading_specialization(in), .push = as_push(push)},
            {params.width, params.height, 1});
    });
    return out;
}

ImageHandle add_kept(Graph& graph, ImageHandle image, const std::string& name) {
    const ImageHandle kept = graph.create_persistent_image(name, graph.desc(image));
    PassBuilder pass = graph.add_transfer_pass("keep_" + name);
    pass.because("meshes are rendered once for each view, the medium in many steps");
    pass.copy_from(image);
    const ImageHandle out = pass.copy_to(kept);
    pass.record([image, out](Commands& commands) { commands.copy(image, out); });
    return out;
}

ImageHandle add_over_meshes(Graph& graph, const MeshInputs& meshes, ImageHandle change,
    const MeshRays& rays, std::uint32_t m) {
    const ImageDesc desc = graph.desc(meshes.picture);
    PassBuilder pass = graph.add_compute_pass("over_meshes");
    pass.because("the picture: meshes, and what the medium hides of them and sends out");
    pass.read("meshes", meshes.picture)
        .read("change", change)
        .sample("mesh_ends", meshes.ends)
        .sample("mesh_radiance", meshes.radiance);
    if (rays.count)
        pass.read("compose_count", rays.count);
    else
        pass.read("progress", rays.progress);
    const ImageHandle out = pass.write("picture", graph.create_image("picture", desc));
    const char* shader =
        rays.count ? "volume/over_meshes.comp:composed" : "volume/over_meshes.comp";
    pass.record([desc, shader, m](Commands& commands) {
        const shader::OverMeshesPush push{m};
        commands.dispatch_over({.shader = shader, .specialization = {}, .push = as_push(push)},
            {desc.width, desc.height, 1});
    });
    return out;
}

} // namespace ockham

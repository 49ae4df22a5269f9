// SPDX-License-Identifier: Apache-2.0
#include "passes/surface/gbuffer.hpp"

#include "framework/core/error.hpp"
#include "passes/shader_variant.hpp"

namespace ockham {

Gbuffer add_gbuffer(
    Graph& graph, const SceneInputs& in, const GbufferParams& params, std::uint32_t max_extent) {
    const SceneFacts& facts = in.scene->facts();
    const std::uint32_t width = params.m * params.width, height = params.m * params.height;
    if (width > max_extent || height > max_extent) {
        fail_input(
            "{} x {} pixels at m = {} need a G-buffer of {} x {} samples; this device has at "
            "most {} per side: use a smaller picture or m",
            params.width, params.height, params.m, width, height, max_extent);
    }
    Gbuffer out{
        .surface = graph.create_image(
            "gbuffer", {.format = VK_FORMAT_R32G32B32A32_UINT, .width = width, .height = height}),
        .depth = graph.create_image(
            "gbuffer.depth", {.format = VK_FORMAT_D32_SFLOAT, .width = width, .height = height}),
        .extra = {},
    };
    if (facts.extra_target()) {
        out.extra = graph.create_image("gbuffer.extra",
            {.format = VK_FORMAT_R32G32B32A32_UINT, .width = width, .height = height});
    } else {
        graph.omit_resource(
            "gbuffer.extra", "no vertex colours and no second set of texture coordinates");
    }

    PassBuilder pass = graph.add_raster_pass("gbuffer");
    pass.because(fmt::format(
        "{} triangles seen at {} x {} samples per pixel", facts.triangles, params.m, params.m));
    // What depth marks as background is never read, so only depth is cleared.
    out.surface = pass.color(out.surface, LoadOp::discard);
    if (out.extra) out.extra = pass.color(out.extra, LoadOp::discard);
    out.depth = pass.depth(out.depth, 0.0f);
    if (in.scene->draws().empty()) {
        pass.record([](Commands&) {});
        return out;
    }
    read_vertices(pass, in);
    pass.read("materials", in.handles.materials, Stage::fragment);
    if (facts.masked_textures) {
        pass.sample(
            "color_textures", in.handles.color_textures, Stage::fragment, Filter::linear_repeat);
    }
    if (facts.normal_maps) {
        pass.sample(
            "data_textures", in.handles.data_textures, Stage::fragment, Filter::linear_repeat);
    }
    pass.record([in](Commands& commands) {
        const SceneFacts& has = in.scene->facts();
        const auto fragment = [&](bool masked) {
            return shader_variant("surface/gbuffer.frag",
                {{"masked", masked}, {"color_textures", masked && has.masked_textures},
                    {"normal_mapped", has.normal_maps}, {"extra", has.extra_target()}});
        };
        const std::string opaque = fragment(false), masked = fragment(true);
        const Specialization vertices = vertex_specialization(in.scene->vertex_layout());
        record_draws(commands, in,
            {.vertex_shader = "surface/gbuffer.vert",
                .fragment_shader = opaque,
                .specialization = vertices},
            {.vertex_shader = "surface/gbuffer.vert",
                .fragment_shader = masked,
                .specialization = vertices},
            Sides::front);
    });
    return out;
}

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
#include "passes/surface/gbuffer.hpp"

#include "framework/core/error.hpp"
#include "framework/graph/format.hpp"
#include "passes/shader_variant.hpp"
#include "shaders/surface/gbuffer.h"

namespace ockham {
namespace {

constexpr std::uint32_t kMaxBlocks = 1u << (32 - TRIANGLE_BLOCK_BITS);

ScreenTile viewport_of(const GbufferParams& params) {
    return params.tile ? *params.tile : ScreenTile{{}, {params.width, params.height}};
}

void set_viewport(Commands& commands, const GbufferParams& params) {
    if (!params.tile) return;
    const auto m = static_cast<int>(params.m);
    commands.set_viewport(-m * params.tile->origin, params.m * params.tile->picture);
}

/// What the alpha test reads.
void read_masks(PassBuilder& pass, const SceneInputs& in) {
    pass.read("materials", in.handles.materials, Stage::fragment);
    if (in.scene->facts().masked_textures) {
        pass.sample(
            "color_textures", in.handles.color_textures, Stage::fragment, Filter::linear_repeat);
    }
}

void read_isosurfaces(PassBuilder& pass, const SceneInputs& in, const MediumInputs& medium) {
    pass.uniform("frame", in.frame, Stage::fragment)
        .uniform("medium_frame", medium.frame, Stage::vertex)
        .uniform("medium_frame", medium.frame, Stage::fragment)
        .sample("volume", medium.handles.volume, Stage::fragment)
        .read("ranges", medium.ranges, Stage::fragment);
}

/// Rays through the samples that the medium's box covers.
void draw_isosurfaces(Commands& commands, const SceneInputs& in, const GbufferParams& params) {
    commands.bind({.vertex_shader = "surface/isosurfaces.vert",
        .fragment_shader = shader_variant("surface/isosurfaces.frag",
            {{"extra", in.scene->facts().extra_target()}, {"slopes", params.slopes}})});
    commands.set_cull(Commands::Cull::back);
    commands.draw(36);
}

void record_packed(PassBuilder& pass, const SceneInputs& in, const GbufferParams& params) {
    read_vertices(pass, in);
    read_masks(pass, in);
    if (in.scene->facts().normal_maps) {
        pass.sample(
            "data_textures", in.handles.data_textures, Stage::fragment, Filter::linear_repeat);
    }
    if (params.medium) read_isosurfaces(pass, in, *params.medium);
    pass.record([in, params](Commands& commands) {
        const SceneFacts& has = in.scene->facts();
        const auto fragment = [&](bool masked) {
            return shader_variant("surface/gbuffer.frag",
                {{"masked", masked}, {"color_textures", masked && has.masked_textures},
                    {"normal_mapped", has.normal_maps}, {"extra", has.extra_target()},
                    {"slopes", params.slopes}});
        };
        const std::string opaque = fragment(false), masked = fragment(true);
        const Specialization vertices = vertex_specialization(in.scene->vertex_layout());
        set_viewport(commands, params);
        record_draws(commands, in,
            {.vertex_shader = "surface/gbuffer.vert",
                .fragment_shader = opaque,
                .specialization = vertices},
            {.vertex_shader = "surface/gbuffer.vert",
                .fragment_shader = masked,
                .specialization = vertices},
            Sides::front);
        if (params.medium) draw_isosurfaces(commands, in, params);
    });
}

void record_visibility(PassBuilder& pass, const SceneInputs& in, const GbufferParams& params) {
    const Draw& last = in.scene->draws().back();
    if (std::uint64_t{last.first_block} + last.instance_count * last.blocks_per_instance >
        kMaxBlocks) {
        fail_input("--gbuffer visibility: more than {} million triangles have no ids; use packed",
            (std::uint64_t{kMaxBlocks} * TRIANGLES_PER_BLOCK) / 1000000);
    }
    read_triangles(pass, in);
    if (in.scene->facts().masked) read_masks(pass, in);
    pass.record([in, params](Commands& commands) {
        const std::string masked = shader_variant("surface/visibility.frag",
            {{"masked", true}, {"color_textures", in.scene->facts().masked_textures}});
        const Specialization vertices = vertex_specialization(in.scene->vertex_layout());
        set_viewport(commands, params);
        record_triangle_draws(commands, in,
            {.vertex_shader = "surface/visibility.vert",
                .fragment_shader = "surface/visibility.frag",
                .specialization = vertices},
            {.vertex_shader = "surface/visibility.vert:masked",
                .fragment_shader = masked,
                .specialization = vertices},
            128.0f * glm::vec2(params.m * viewport_of(params).picture));
    });
}

} // namespace

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
    // Of an empty scene only depth is ever read.
    const bool packed = params.layout == GbufferLayout::packed || in.scene->draws().empty();
    const auto create = [&](const char* name, VkFormat format) {
        return graph.create_image(name, {.format = format, .width = width, .height = height});
    };
    Gbuffer out{
        .surface = create("gbuffer", packed ? VK_FORMAT_R32G32B32A32_UINT : VK_FORMAT_R32_UINT),
        .depth = create("gbuffer.depth", VK_FORMAT_D32_SFLOAT),
        .extra = {},
        .slopes = {},
        .layout = packed ? GbufferLayout::packed : GbufferLayout::visibility,
        .scene = packed ? SceneInputs{} : in,
    };
    if (packed && facts.extra_target()) {
        out.extra = create("gbuffer.extra", VK_FORMAT_R32G32B32A32_UINT);
    } else {
        graph.omit_resource(
            "gbuffer.extra", packed ? "no vertex colours and no second set of texture coordinates"
                                    : "--gbuffer visibility: read from the triangles");
    }
    if (packed && params.slopes) out.slopes = create("gbuffer.slopes", VK_FORMAT_R32_UINT);

    PassBuilder pass = graph.add_raster_pass("gbuffer");
    pass.because(
        fmt::format("{} triangles{} seen at {} x {} samples per pixel, {}: {} bytes a sample",
            facts.triangles, params.medium ? " and opaque isosurfaces" : "", params.m, params.m,
            packed ? "packed" : "as ids", gbuffer_bytes_per_sample(graph)));
    if (packed) {
        // What depth marks as background is never read, so only depth is cleared.
        out.surface = pass.color(out.surface, LoadOp::discard);
        if (out.extra) out.extra = pass.color(out.extra, LoadOp::discard);
        if (out.slopes) out.slopes = pass.color(out.slopes, LoadOp::discard);
    } else {
        static_assert(NO_TRIANGLE == 0);
        out.surface = pass.color(out.surface, LoadOp::clear, {});
    }
    out.depth = pass.depth(out.depth, 0.0f);
    if (in.scene->draws().empty()) {
        pass.record([](Commands&) {});
    } else if (packed) {
        record_packed(pass, in, params);
    } else {
        record_visibility(pass, in, params);
    }
    return out;
}

std::uint32_t gbuffer_bytes_per_sample(const Graph& graph) {
    std::uint32_t bytes = 0;
    for (const char* name : {"gbuffer", "gbuffer.depth", "gbuffer.extra", "gbuffer.slopes"}) {
        const ImageHandle image = graph.find_image(name);
        if (image) bytes += texel_bytes(graph.desc(image).format);
    }
    return bytes;
}

void read_gbuffer(PassBuilder& pass, const Gbuffer& gbuffer, Stage stage) {
    pass.read("gbuffer", gbuffer.surface, stage);
    if (gbuffer.layout == GbufferLayout::packed) {
        pass.sample("gbuffer_depth", gbuffer.depth, stage);
        if (gbuffer.extra) pass.read("gbuffer_extra", gbuffer.extra, stage);
        if (gbuffer.slopes) pass.read("gbuffer_slopes", gbuffer.slopes, stage);
        return;
    }
    const SceneHandles& scene = gbuffer.scene.handles;
    pass.read("vertices", scene.vertices, stage)
        .read("instances", scene.instances, stage)
        .read("indices", scene.indices, stage)
        .read("triangle_blocks", scene.triangle_blocks, stage)
        .read("materials", scene.materials, stage);
    if (scene.data_textures)
        pass.sample("data_textures", scene.data_textures, stage, Filter::linear_repeat);
}

std::string gbuffer_variant(
    std::string_view shader, std::string_view mode, const Gbuffer& gbuffer) {
    const bool ids = gbuffer.layout == GbufferLayout::visibility;
    return shader_variant(
        shader, {{mode, !mode.empty()}, {"visibility", ids},
                    {"data_textures", ids && bool(gbuffer.scene.handles.data_textures)}});
}

Specialization gbuffer_specialization(const Gbuffer& gbuffer) {
    if (gbuffer.layout == GbufferLayout::packed) return {};
    const SceneFacts& facts = gbuffer.scene.scene->facts();
    Specialization out = vertex_specialization(gbuffer.scene.scene->vertex_layout());
    out.emplace_back(SPEC_NORMAL_MAPS, facts.normal_maps);
    out.emplace_back(SPEC_SHADING_DATA_TEXTURES, facts.shading_data_textures);
    out.emplace_back(SPEC_SECOND_COORDINATES, facts.second_coordinates);
    return out;
}

} // namespace ockham

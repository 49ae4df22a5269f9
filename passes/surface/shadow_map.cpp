// SPDX-License-Identifier: Apache-2.0
#include "passes/surface/shadow_map.hpp"

#include "passes/shader_variant.hpp"

namespace ockham {

ImageHandle add_shadow_map(Graph& graph, const SceneInputs& in, ImageHandle map) {
    const SceneFacts& facts = in.scene->facts();
    PassBuilder pass = graph.add_raster_pass("shadow_map");
    pass.because("the first directional light casts a shadow");
    const ImageHandle out = pass.depth(map, 0.0f);
    read_vertices(pass, in);
    if (facts.masked) {
        pass.read("materials", in.handles.materials, Stage::fragment);
        if (facts.masked_textures) {
            pass.sample("color_textures", in.handles.color_textures, Stage::fragment,
                Filter::linear_repeat);
        }
    }
    pass.record([in](Commands& commands) {
        const std::string masked = shader_variant(
            "surface/shadow_map.frag", {{"color_textures", in.scene->facts().masked_textures}});
        RasterCall opaque{.vertex_shader = "surface/shadow_map.vert",
            .fragment_shader = {},
            .specialization = vertex_specialization(in.scene->vertex_layout())};
        RasterCall holes = opaque;
        holes.fragment_shader = masked;
        // Walls of one sheet stop the sun from behind too.
        record_draws(commands, in, opaque, holes, Sides::both);
    });
    return out;
}

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
#include "passes/surface/draw_scene.hpp"

#include "shaders/surface/gbuffer.h"

namespace ockham {

static_assert(ATTRIBUTE_ABSENT == kNone, "absent attributes are named alike in C++ and GLSL");

namespace {

void read_attributes(PassBuilder& pass, const SceneInputs& in) {
    pass.uniform("frame", in.frame, Stage::vertex)
        .read("vertices", in.handles.vertices, Stage::vertex)
        .read("instances", in.handles.instances, Stage::vertex);
}

/// Calls `record(draw)` for each draw, what is opaque first, with its state bound; `bound()` before
/// the first of either pipeline.
template <class Bound, class Record>
void for_each_draw(Commands& commands, const SceneInputs& in, const RasterCall& opaque,
    const RasterCall& masked, Sides sides, Bound bound, Record record) {
    for (const bool with_holes : {false, true}) {
        bool first = true;
        for (const Draw& draw : in.scene->draws()) {
            if (draw.masked != with_holes) continue;
            if (first) {
                commands.bind(with_holes ? masked : opaque);
                bound();
                first = false;
            }
            const bool both = draw.double_sided || sides == Sides::both;
            commands.set_cull(both ? Commands::Cull::none : Commands::Cull::back, draw.mirrored);
            record(draw);
        }
    }
}

} // namespace

void read_vertices(PassBuilder& pass, const SceneInputs& in) {
    read_attributes(pass, in);
    pass.indices(in.handles.indices);
}

void read_triangles(PassBuilder& pass, const SceneInputs& in) {
    read_attributes(pass, in);
    pass.read("indices", in.handles.indices, Stage::vertex);
}

Specialization vertex_specialization(const VertexLayout& layout) {
    return {{SPEC_VERTEX_STRIDE, layout.stride}, {SPEC_TANGENT_OFFSET, layout.tangent},
        {SPEC_UV1_OFFSET, layout.uv1}, {SPEC_COLOR_OFFSET, layout.color}};
}

void record_draws(Commands& commands, const SceneInputs& in, const RasterCall& opaque,
    const RasterCall& masked, Sides sides) {
    for_each_draw(
        commands, in, opaque, masked, sides, [&] { commands.bind_indices(in.handles.indices); },
        [&](const Draw& draw) {
            // A depth-only pipeline has no use for the material.
            if (draw.masked || !opaque.fragment_shader.empty())
                commands.push(as_push(shader::DrawPush{draw.material}));
            commands.draw_indexed(draw.index_count, draw.instance_count, draw.first_index,
                draw.vertex_offset, draw.first_instance);
        });
}

void record_triangle_draws(Commands& commands, const SceneInputs& in, const RasterCall& opaque,
    const RasterCall& masked, glm::vec2 steps) {
    for_each_draw(
        commands, in, opaque, masked, Sides::front, [] {},
        [&](const Draw& draw) {
            commands.push(as_push(shader::VisibilityPush{.material = draw.material,
                .first_index = draw.first_index,
                .vertex_offset = draw.vertex_offset,
                .first_instance = draw.first_instance,
                .first_triangle = draw.first_block * TRIANGLES_PER_BLOCK,
                .triangles_per_instance = draw.blocks_per_instance * TRIANGLES_PER_BLOCK,
                .steps = steps}));
            commands.draw(
                draw.index_count, draw.instance_count, draw.first_index, draw.first_instance);
        });
}

} // namespace ockham

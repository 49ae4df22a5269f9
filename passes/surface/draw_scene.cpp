// SPDX-License-Identifier: Apache-2.0
#include "passes/surface/draw_scene.hpp"

#include "shaders/surface/gbuffer.h"

namespace ockham {

static_assert(ATTRIBUTE_ABSENT == kNone, "absent attributes are named alike in C++ and GLSL");

void read_vertices(PassBuilder& pass, const SceneInputs& in) {
    pass.read("frame", in.frame, Stage::vertex)
        .read("vertices", in.handles.vertices, Stage::vertex)
        .read("instances", in.handles.instances, Stage::vertex)
        .indices(in.handles.indices);
}

Specialization vertex_specialization(const VertexLayout& layout) {
    return {{SPEC_VERTEX_STRIDE, layout.stride}, {SPEC_NORMAL_OFFSET, layout.normal},
        {SPEC_TANGENT_OFFSET, layout.tangent}, {SPEC_UV0_OFFSET, layout.uv[0]},
        {SPEC_UV1_OFFSET, layout.uv[1]}, {SPEC_COLOR_OFFSET, layout.color}};
}

void record_draws(Commands& commands, const SceneInputs& in, const RasterCall& opaque,
    const RasterCall& masked, Sides sides) {
    for (const bool with_holes : {false, true}) {
        const RasterCall& call = with_holes ? masked : opaque;
        bool bound = false;
        for (const Draw& draw : in.scene->draws()) {
            if (draw.masked != with_holes) continue;
            if (!bound) {
                commands.bind(call);
                commands.bind_indices(in.handles.indices);
                bound = true;
            }
            const bool both = draw.double_sided || sides == Sides::both;
            commands.set_cull(both ? Commands::Cull::none : Commands::Cull::back, draw.mirrored);
            // A depth-only pipeline has no use for the material.
            if (!call.fragment_shader.empty())
                commands.push(as_push(shader::DrawPush{draw.material}));
            commands.draw_indexed(draw.index_count, draw.instance_count, draw.first_index,
                draw.vertex_offset, draw.first_instance);
        }
    }
}

} // namespace ockham

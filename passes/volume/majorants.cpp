// SPDX-License-Identifier: Apache-2.0
#include "passes/volume/majorants.hpp"

#include "framework/runtime/commands.hpp"
#include "shaders/volume/ranges.h"
#include "shaders/volume/reach.h"

#include <fmt/format.h>

namespace ockham {
namespace {

BufferHandle add_ranges(Graph& graph, const VolumeFacts& facts, ImageHandle volume) {
    const glm::uvec3 cells = facts.cells;
    const std::uint64_t count = std::uint64_t{cells.x} * cells.y * cells.z;
    PassBuilder pass = graph.add_compute_pass("ranges");
    pass.because("cells without a surface or without a medium are skipped by what they hold");
    pass.sample("volume", volume);
    const BufferHandle ranges =
        pass.write("ranges", graph.create_persistent_buffer("ranges", {count * sizeof(glm::vec2)}));
    pass.record([push = shader::RangesPush{facts.dims, cells}](Commands& commands) {
        commands.dispatch_over(
            {.shader = "volume/ranges.comp", .specialization = {}, .push = as_push(push)},
            push.cells);
    });
    return ranges;
}

BufferHandle add_opacities(Graph& graph, const VolumeHandles& handles, BufferHandle frame,
    BufferHandle ranges, glm::uvec3 cells) {
    PassBuilder pass = graph.add_compute_pass("majorants");
    pass.because("free flights are drawn by the greatest extinction of each cell");
    pass.uniform("frame", frame)
        .read("transfer", handles.transfer)
        .read("opacity_max", handles.opacity_max)
        .read("ranges", ranges);
    const std::uint64_t count = std::uint64_t{cells.x} * cells.y * cells.z;
    const BufferHandle out =
        pass.write("majorants", graph.create_buffer("opacities", {count * sizeof(float)}));
    pass.record([cells](Commands& commands) {
        commands.dispatch_over({.shader = "volume/majorants.comp"}, cells);
    });
    return out;
}

/// How far rays may go through empty cells at once; an axis at a time.
BufferHandle add_reach(Graph& graph, BufferHandle opacities, glm::uvec3 cells) {
    BufferHandle out = opacities;
    const BufferDesc desc = graph.desc(opacities);
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
        PassBuilder pass = graph.add_compute_pass(fmt::format("reach_{}", "xyz"[axis]));
        pass.because("rays leave all empty cells around them at once");
        pass.read("from", out);
        out = pass.write("to", axis < 2
                                   ? graph.create_buffer(fmt::format("reach_{}", "xyz"[axis]), desc)
                                   : graph.create_persistent_buffer("majorants", desc));
        pass.record([push = shader::ReachPush{cells, axis}](Commands& commands) {
            commands.dispatch_over(
                {.shader = "volume/reach.comp", .specialization = {}, .push = as_push(push)},
                push.cells);
        });
    }
    return out;
}

} // namespace

Majorants add_majorants(Graph& graph, const VolumeFacts& facts, const VolumeHandles& handles,
    BufferHandle frame, bool surfaces, const MajorantsChange& changed) {
    Majorants out;
    if (facts.homogeneous) {
        graph.omit_pass("majorants", "the opacity is the same everywhere: one majorant does");
        if (!surfaces) {
            graph.omit_pass("ranges", "there are neither isovalues nor majorants");
            return out;
        }
    }
    {
        const GuardScope guard = graph.when(changed.volume);
        out.ranges = add_ranges(graph, facts, handles.volume);
    }
    if (facts.homogeneous) return out;

    const GuardScope guard = graph.when(changed.transfer);
    out.majorants = add_reach(
        graph, add_opacities(graph, handles, frame, out.ranges, facts.cells), facts.cells);
    return out;
}

} // namespace ockham

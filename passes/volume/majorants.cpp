// SPDX-License-Identifier: Apache-2.0
#include "passes/volume/majorants.hpp"

#include "framework/runtime/commands.hpp"
#include "shaders/volume/ranges.h"

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
    PassBuilder pass = graph.add_compute_pass("majorants");
    pass.because("free flights are drawn by the greatest extinction of each cell");
    pass.read("frame", frame)
        .read("transfer", handles.transfer)
        .read("opacity_max", handles.opacity_max)
        .read("ranges", out.ranges);
    const std::uint64_t count = graph.desc(out.ranges).bytes / sizeof(glm::vec2);
    out.majorants = pass.write(
        "majorants", graph.create_persistent_buffer("majorants", {count * sizeof(float)}));
    pass.record([cells = facts.cells](Commands& commands) {
        commands.dispatch_over({.shader = "volume/majorants.comp"}, cells);
    });
    return out;
}

} // namespace ockham

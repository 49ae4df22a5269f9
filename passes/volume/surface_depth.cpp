// SPDX-License-Identifier: Apache-2.0
#include "passes/volume/surface_depth.hpp"

#include "framework/core/error.hpp"
#include "framework/runtime/commands.hpp"
#include "shaders/volume/surface_depth.h"

namespace ockham {
namespace {

constexpr std::uint32_t kMostSteps = 32768; // of one invocation, which drivers may stop at 65,535

/// Images that live on between executions, cleared when told to.
SurfaceDepth add_state(Graph& graph, const ImageDesc& depth, Condition restart) {
    ImageDesc count = depth;
    count.format = VK_FORMAT_R32_UINT;
    SurfaceDepth out{.depth = graph.create_persistent_image("surface_depth", depth),
        .candidates = graph.create_persistent_image("surface_candidates", count)};
    const GuardScope guard = graph.when(restart);
    PassBuilder pass = graph.add_transfer_pass("surface_depth.restart");
    pass.because("what was found is of another view, field or isovalue");
    out.depth = pass.copy_to(out.depth);
    out.candidates = pass.copy_to(out.candidates);
    pass.record([out](Commands& commands) {
        commands.clear(out.depth, {1, 0, 0, 0});
        commands.clear(out.candidates, {0, 0, 0, 0});
    });
    return out;
}

} // namespace

SurfaceDepth add_surface_depth(
    Graph& graph, const MediumInputs& in, const SurfaceDepthParams& params, Condition restart) {
    const bool stochastic = params.search == SurfaceSearch::stochastic;
    const std::uint32_t steps = stochastic ? params.candidates : params.steps;
    check(in.surfaces, "a search for surfaces needs an isovalue");
    check(steps >= 1 && steps <= kMostSteps, "a search takes 1 to 32768 steps at a time");
    const ImageDesc desc{
        .format = VK_FORMAT_R32G32_SFLOAT, .width = params.width, .height = params.height};
    SurfaceDepth out;
    if (stochastic) {
        out = add_state(graph, desc, restart);
    } else {
        out.depth = graph.create_image("surface_depth", desc);
    }

    PassBuilder pass = graph.add_compute_pass("surface_depth");
    pass.because("the surface ends what is seen of the medium");
    const MediumUse use{.tracking = false, .light = false};
    read_medium(pass, in, use);
    if (stochastic) {
        out.depth = pass.read_write("surface_depth", out.depth);
        out.candidates = pass.read_write("candidates", out.candidates);
    } else {
        out.depth = pass.write("surface_depth", out.depth);
    }
    const bool exact = params.search == SurfaceSearch::exact;
    const char* const shader = stochastic ? "volume/surface_depth.comp:stochastic,surfaces"
                               : exact    ? "volume/surface_depth.comp:exact,surfaces"
                                          : "volume/surface_depth.comp:march,surfaces";
    pass.record([params, steps, shader, exact](Commands& commands) {
        const shader::SurfaceDepthPush push{steps};
        ComputeCall call{.shader = shader};
        if (!exact) call.push = as_push(push);
        commands.dispatch_over(call, {params.width, params.height, 1});
    });
    return out;
}

} // namespace ockham

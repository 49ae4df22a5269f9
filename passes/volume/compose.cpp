// SPDX-License-Identifier: Apache-2.0
#include "passes/volume/compose.hpp"

#include "framework/core/error.hpp"
#include "framework/runtime/commands.hpp"
#include "shaders/volume/compose.h"

namespace ockham {

Composed add_compose(
    Graph& graph, const ComposeInputs& in, const ComposeParams& params, Condition restart) {
    check(
        params.samples >= 1 && params.iterations >= 1, "a composition needs samples and a budget");
    check(params.step_voxels > 0 && params.step_depth > 0, "steps must be longer than nothing");
    const ImageDesc radiance{
        .format = VK_FORMAT_R32G32B32A32_SFLOAT, .width = params.width, .height = params.height};
    ImageDesc count = radiance, state = radiance;
    count.format = VK_FORMAT_R32_UINT;
    state.format = VK_FORMAT_R32G32B32A32_UINT;
    state.layers = 3;
    Composed out{.picture = graph.create_image("composed", radiance),
        .sum = graph.create_persistent_image("compose_sum", radiance),
        .count = graph.create_persistent_image("compose_count", count),
        .state = graph.create_persistent_image("compose_state", state),
        .begins = std::make_shared<bool>(true)};
    {
        const GuardScope guard = graph.when(restart);
        PassBuilder pass = graph.add_transfer_pass("compose_restart");
        pass.because("a sum is of one view");
        out.sum = pass.copy_to(out.sum);
        out.count = pass.copy_to(out.count);
        pass.record([sum = out.sum, counts = out.count](Commands& commands) {
            commands.clear(sum, {0, 0, 0, 0});
            commands.clear(counts, {0, 0, 0, 0});
        });
    }
    const bool depth = in.medium.surfaces && in.surface_depth;
    const std::string shader = mesh_variant(
        medium_variant("volume/compose.comp", depth ? "depth_image" : "", in.medium), in.medium);
    const Specialization constants = medium_specialization(in.medium);
    for (std::uint32_t sample = 0; sample < params.samples; ++sample) {
        PassBuilder pass =
            graph.add_compute_pass(sample == 0 ? "compose" : fmt::format("compose.{}", sample));
        pass.because("the picture, from the medium, its surfaces and the cached light");
        read_medium(pass, in.medium);
        read_meshes(pass, in.medium, true);
        pass.read("cache_index", in.cache_index).read("cache_cells", in.cache_cells);
        if (depth) pass.read("surface_depth", in.surface_depth);
        out.sum = pass.read_write("compose_sum", out.sum);
        out.count = pass.read_write("compose_count", out.count);
        out.state = pass.read_write("compose_state", out.state);
        out.picture = pass.write("composed", out.picture);
        pass.record([params, shader, constants, begins = out.begins](Commands& commands) {
            const shader::ComposePush push{.iterations = params.iterations,
                .jitter = params.jitter ? 1u : 0u,
                .step_voxels = params.step_voxels,
                .step_depth = params.step_depth,
                .begins = *begins ? 1u : 0u};
            commands.dispatch_over(
                {.shader = shader, .specialization = constants, .push = as_push(push)},
                {params.width, params.height, 1});
        });
    }
    return out;
}

} // namespace ockham

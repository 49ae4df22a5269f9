// SPDX-License-Identifier: Apache-2.0
#include "passes/surface/variance_history.hpp"

#include "framework/core/error.hpp"
#include "framework/runtime/commands.hpp"
#include "shaders/surface/variance_history.h"

namespace ockham {

ImageHandle add_variance_history(Graph& graph, const VarianceHistoryInputs& in, float keep) {
    check(keep >= 0.0f && keep < 1.0f, "keep lies in [0, 1)");
    const ImageDesc desc = graph.desc(in.variance);
    const History<ImageHandle> history = graph.create_history_image("variance_history", desc, 1);
    PassBuilder pass = graph.add_compute_pass("variance_history");
    pass.because("the camera moves: expected variance falls little by little, lest counts flicker");
    pass.uniform("frame", in.frame)
        .uniform("frame_before", in.frame_before)
        .read("variance", in.variance)
        .read("first_surface", in.first_surface)
        .sample("history_before", history.previous[0]);
    const ImageHandle out = pass.write("history", history.now);
    pass.record([desc, keep](Commands& commands) {
        const shader::VarianceHistoryPush push{keep};
        commands.dispatch_over({.shader = "surface/variance_history.comp",
                                   .specialization = {},
                                   .push = as_push(push)},
            {desc.width, desc.height, 1});
    });
    return out;
}

} // namespace ockham

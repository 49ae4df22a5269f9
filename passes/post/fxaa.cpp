// SPDX-License-Identifier: Apache-2.0
#include "passes/post/fxaa.hpp"

#include "framework/runtime/commands.hpp"
#include "shaders/post/fxaa.h"

namespace ockham {

ImageHandle add_fxaa(
    Graph& graph, ImageHandle radiance, ImageHandle display, const FxaaParams& params) {
    const ImageDesc desc = graph.desc(radiance);
    PassBuilder pass = graph.add_compute_pass("fxaa");
    pass.because("--method fxaa: smooths the edges that the picture shows");
    pass.sample("display", display, Stage::compute, Filter::linear_clamp);
    pass.sample("radiance", radiance);
    const ImageHandle out = pass.write("filtered", graph.create_image("fxaa", desc));
    pass.record([desc, params](Commands& commands) {
        const shader::FxaaPush push{params.subpixel, params.threshold, params.threshold_min};
        commands.dispatch_over(
            {.shader = "post/fxaa.comp", .push = as_push(push)}, {desc.width, desc.height, 1});
    });
    return out;
}

} // namespace ockham

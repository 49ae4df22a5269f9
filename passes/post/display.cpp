// SPDX-License-Identifier: Apache-2.0
#include "passes/post/display.hpp"

#include "framework/runtime/commands.hpp"

namespace ockham {

ImageHandle add_display(Graph& graph, ImageHandle radiance) {
    ImageDesc desc = graph.desc(radiance);
    desc.format = VK_FORMAT_R16G16B16A16_SFLOAT;
    PassBuilder pass = graph.add_compute_pass("display");
    pass.because("edges are looked for in what a display shows");
    pass.sample("radiance", radiance);
    const ImageHandle out = pass.write("display", graph.create_image("display", desc));
    pass.record([desc](Commands& commands) {
        commands.dispatch_over({.shader = "post/display.comp"}, {desc.width, desc.height, 1});
    });
    return out;
}

} // namespace ockham

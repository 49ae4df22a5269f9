// SPDX-License-Identifier: Apache-2.0
#include "passes/surface/resolve.hpp"

#include "framework/runtime/commands.hpp"
#include "shaders/surface/resolve.h"

namespace ockham {
namespace {

/// Declares the pass around what the mode reads.
ImageHandle finish(
    Graph& graph, PassBuilder& pass, ImageHandle shaded_sum, std::uint32_t k, const char* shader) {
    const ImageDesc desc = graph.desc(shaded_sum);
    pass.read("shaded_sum", shaded_sum);
    const ImageHandle out = pass.write("radiance", graph.create_image("radiance", desc));
    pass.record([desc, k, shader](Commands& commands) {
        const shader::ResolvePush push{.size = {desc.width, desc.height}, .count = k};
        commands.dispatch_over({.shader = shader, .specialization = {}, .push = as_push(push)},
            {desc.width, desc.height, 1});
    });
    return out;
}

} // namespace

ImageHandle add_resolve(
    Graph& graph, ImageHandle shaded_sum, ImageHandle first_sample, ImageHandle sample_count) {
    PassBuilder pass = graph.add_compute_pass("resolve");
    pass.because("the mean of each pixel's samples");
    pass.read("first_sample", first_sample).read("sample_count", sample_count);
    return finish(graph, pass, shaded_sum, 0, "surface/resolve.comp");
}

ImageHandle add_resolve_uniform(Graph& graph, ImageHandle shaded_sum, std::uint32_t k) {
    PassBuilder pass = graph.add_compute_pass("resolve");
    pass.because("the mean of each pixel's samples");
    return finish(graph, pass, shaded_sum, k, "surface/resolve.comp:uniform");
}

} // namespace ockham

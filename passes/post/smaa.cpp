// SPDX-License-Identifier: Apache-2.0
#include "passes/post/smaa.hpp"

#include "framework/runtime/commands.hpp"
#include "shaders/post/smaa.h"

namespace ockham {

Smaa add_smaa(Graph& graph, ImageHandle radiance, ImageHandle display, const SmaaParams& params) {
    const ImageDesc desc = graph.desc(radiance);
    const auto create = [&](const char* name, VkFormat format) {
        return graph.create_image(
            name, {.format = format, .width = desc.width, .height = desc.height});
    };
    const auto record = [desc](const char* shader) {
        return [desc, shader](Commands& commands) {
            commands.dispatch_over({.shader = shader}, {desc.width, desc.height, 1});
        };
    };
    Smaa out;

    PassBuilder edges = graph.add_compute_pass("smaa_edges");
    edges.because("--method smaa: finds the edges that the picture shows");
    edges.sample("display", display);
    out.edges = edges.write("edges", create("smaa_edges", VK_FORMAT_R8_UINT));
    edges.record([desc, params](Commands& commands) {
        const shader::SmaaPush push{params.threshold};
        commands.dispatch_over({.shader = "post/smaa_edges.comp", .push = as_push(push)},
            {desc.width, desc.height, 1});
    });

    PassBuilder weights = graph.add_compute_pass("smaa_weights");
    weights.because("--method smaa: what the line behind each edge cuts off its pixels");
    weights.sample("edges", out.edges);
    out.weights = weights.write("weights", create("smaa_weights", VK_FORMAT_R16G16B16A16_SFLOAT));
    weights.record(record("post/smaa_weights.comp"));

    PassBuilder blend = graph.add_compute_pass("smaa_blend");
    blend.because("--method smaa: blends the pixels on edges");
    blend.sample("radiance", radiance).sample("weights", out.weights);
    out.radiance = blend.write("filtered", create("smaa", desc.format));
    blend.record(record("post/smaa_blend.comp"));
    return out;
}

} // namespace ockham

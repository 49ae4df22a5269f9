// SPDX-License-Identifier: Apache-2.0
#include "passes/post/taa.hpp"

#include "shaders/post/taa.h"

namespace ockham {
namespace {

/// The digits of `index` in a base, mirrored at the point.
float radical_inverse(std::uint32_t index, std::uint32_t base) {
    double result = 0, digit = 1;
    for (; index > 0; index /= base) {
        digit /= base;
        result += digit * (index % base);
    }
    return static_cast<float>(result);
}

} // namespace

glm::vec2 taa_jitter(std::uint32_t index) {
    return glm::vec2(radical_inverse(index + 1, 2), radical_inverse(index + 1, 3)) - 0.5f;
}

ImageHandle add_taa(Graph& graph, const TaaInputs& in) {
    const ImageDesc desc = graph.desc(in.radiance);
    History<BufferHandle> views =
        graph.create_history_buffer("taa_view", {sizeof(shader::TaaView)}, 1);
    History<ImageHandle> pictures = graph.create_history_image("taa", desc, 1);

    PassBuilder view = graph.add_compute_pass("taa_view");
    view.because("--method taa: follows the camera");
    view.uniform("frame", in.frame).read("previous_view", views.previous[0]);
    views.now = view.write("view", views.now);
    view.record([](Commands& commands) {
        commands.dispatch({.shader = "post/taa_view.comp"}, {1, 1, 1});
    });

    PassBuilder pass = graph.add_compute_pass("taa");
    pass.because("--method taa: adds this frame's sample to those of the frames before");
    read_gbuffer(pass, in.gbuffer);
    pass.uniform("frame", in.frame)
        .sample("radiance", in.radiance)
        .sample("history", pictures.previous[0])
        .read("previous_view", views.previous[0])
        .read("view", views.now);
    const ImageHandle out = pass.write("accumulated", pictures.now);
    pass.record([desc, gbuffer = in.gbuffer](Commands& commands) {
        const std::string shader = gbuffer_variant("post/taa.comp", "", gbuffer);
        commands.dispatch_over(
            {.shader = shader, .specialization = gbuffer_specialization(gbuffer), .push = {}},
            {desc.width, desc.height, 1});
    });
    return out;
}

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
#include "passes/surface/first_sample.hpp"

#include "shaders/surface/shade.h"

namespace ockham {

ImageHandle add_first_sample(
    Graph& graph, const ShadingInputs& in, const ShadingParams& params, ImageHandle clusters) {
    samples_per_dispatch(
        in.scene.scene->facts(), params, in.medium); // refuses what a kernel cannot finish
    const ImageHandle image = graph.create_image("first_sample",
        {.format = VK_FORMAT_R32G32B32A32_SFLOAT, .width = params.width, .height = params.height});
    PassBuilder pass = graph.add_compute_pass("first_sample");
    pass.because(params.m == 1
                     ? "m = 1: one sample per pixel is the picture"
                     : "one shaded sample per pixel shows the metrics where shading varies");
    read_shading(pass, in);
    if (clusters) {
        // Without means nothing reads them, but something must be bound.
        pass.sample("clusters", clusters).sample("surface_means", in.means ? in.means : clusters);
    }
    const ImageHandle out = pass.write("first_sample", image);
    pass.record([in, params, clusters](Commands& commands) {
        const shader::ShadePush push = one_sample_push(params);
        const std::string shader =
            shading_variant("surface/first_sample.comp", clusters ? "stratified" : "", in);
        commands.dispatch_over({.shader = shader,
                                   .specialization = shading_specialization(in, bool(clusters)),
                                   .push = as_push(push)},
            {params.width, params.height, 1});
    });
    return out;
}

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
#include "passes/surface/sraa.hpp"

#include "framework/runtime/commands.hpp"
#include "shaders/surface/sraa.h"

namespace ockham {

ImageHandle add_sraa(Graph& graph, const SraaInputs& in, const SraaParams& params) {
    const ImageDesc desc = graph.desc(in.first_sample);
    PassBuilder pass = graph.add_compute_pass("sraa");
    pass.because("--method sraa: spreads each shaded sample over its surface");
    read_gbuffer(pass, in.gbuffer);
    pass.uniform("frame", in.frame).sample("first_sample", in.first_sample);
    const ImageHandle out = pass.write("reconstructed", graph.create_image("sraa", desc));
    pass.record([desc, params, gbuffer = in.gbuffer](Commands& commands) {
        const shader::SraaPush push{params.radius, params.plane_error, params.normal_power};
        const std::string shader = gbuffer_variant("surface/sraa.comp", "", gbuffer);
        commands.dispatch_over({.shader = shader,
                                   .specialization = gbuffer_specialization(gbuffer),
                                   .push = as_push(push)},
            {desc.width, desc.height, 1});
    });
    return out;
}

} // namespace ockham

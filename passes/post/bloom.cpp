// SPDX-License-Identifier: Apache-2.0
#include "passes/post/bloom.hpp"

#include "framework/core/error.hpp"
#include "framework/runtime/commands.hpp"
#include "shaders/post/bloom.h"

#include <cmath>

namespace ockham {
namespace {

/// One axis of the Gaussian: `source` blurred, of which `share` replaces `sharp`.
ImageHandle add_axis(Graph& graph, const char* name, ImageHandle sharp, ImageHandle source,
    const shader::BloomPush& push) {
    const ImageDesc desc = graph.desc(sharp);
    PassBuilder pass = graph.add_compute_pass(name);
    pass.because("--bloom: a lens scatters light");
    pass.sample("sharp", sharp).sample("source", source);
    const ImageHandle out = pass.write("target", graph.create_image(name, desc));
    pass.record([desc, push](Commands& commands) {
        commands.dispatch_over(
            {.shader = "post/bloom.comp", .push = as_push(push)}, {desc.width, desc.height, 1});
    });
    return out;
}

} // namespace

ImageHandle add_bloom(Graph& graph, ImageHandle radiance, const BloomParams& params) {
    check(params.share >= 0 && params.share <= 1 && params.sigma > 0, "parameters of the bloom");
    shader::BloomPush push{.axis = {1, 0},
        .radius = static_cast<std::int32_t>(std::ceil(4 * params.sigma)),
        .sigma = params.sigma,
        .share = 1};
    const ImageHandle rows = add_axis(graph, "bloom_rows", radiance, radiance, push);
    push.axis = {0, 1};
    push.share = params.share;
    return add_axis(graph, "bloom", radiance, rows, push);
}

} // namespace ockham

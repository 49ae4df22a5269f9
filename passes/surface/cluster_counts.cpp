// SPDX-License-Identifier: Apache-2.0
#include "passes/surface/cluster_counts.hpp"

#include "framework/core/error.hpp"
#include "framework/runtime/commands.hpp"
#include "shaders/surface/cluster_counts.h"

namespace ockham {

ImageHandle add_cluster_counts(Graph& graph, ImageHandle labels, const ClusterCountsParams& params,
    const std::string& reason) {
    check(params.single >= 1 && params.single <= params.samples && params.several <= params.samples,
        "counts lie in 1 ... n");
    ImageDesc desc = graph.desc(labels);
    desc.format = VK_FORMAT_R8_UINT;
    PassBuilder pass = graph.add_compute_pass("cluster_counts");
    pass.because(reason);
    pass.sample("clusters", labels);
    const ImageHandle out = pass.write("sample_count", graph.create_image("sample_count", desc));
    pass.record([desc, params](Commands& commands) {
        const shader::ClusterCountsPush push{params.samples, params.single, params.several};
        commands.dispatch_over({.shader = "surface/cluster_counts.comp", .push = as_push(push)},
            {desc.width, desc.height, 1});
    });
    return out;
}

} // namespace ockham

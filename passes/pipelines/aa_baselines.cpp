// SPDX-License-Identifier: Apache-2.0
#include "passes/pipelines/aa_baselines.hpp"

#include "passes/post/display.hpp"
#include "passes/post/fxaa.hpp"
#include "passes/post/smaa.hpp"

namespace ockham {

bool is_baseline_pass(std::string_view pass) {
    return pass == "display" || pass == "fxaa" || pass == "sraa" || pass == "cluster_counts" ||
           pass.starts_with("taa") || pass.starts_with("smaa_");
}

ImageHandle add_fxaa_picture(Graph& graph, ImageHandle first_sample) {
    return add_fxaa(graph, first_sample, add_display(graph, first_sample));
}

ImageHandle add_smaa_picture(Graph& graph, ImageHandle first_sample) {
    return add_smaa(graph, first_sample, add_display(graph, first_sample)).radiance;
}

} // namespace ockham

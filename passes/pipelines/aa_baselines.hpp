// SPDX-License-Identifier: Apache-2.0
// The anti-aliasing that adaptive supersampling is measured against, each in the same graph, with
// the same G-buffer and the same shading. Called by adaptive_aa for those methods.
#pragma once

#include "passes/surface/shading_inputs.hpp"

#include <string_view>

namespace ockham {

/// True for the passes declared here: they count as shading.
bool is_baseline_pass(std::string_view pass);

/// Filters of the finished picture of one sample per pixel (params.m = 1). Return rgba32f, linear.
ImageHandle add_fxaa_picture(Graph& graph, ImageHandle first_sample);
ImageHandle add_smaa_picture(Graph& graph, ImageHandle first_sample);

} // namespace ockham

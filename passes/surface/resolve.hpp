// SPDX-License-Identifier: Apache-2.0
// Sums to means: the picture. Linear and unclamped; exposure and encoding come with the file.
#pragma once

#include "framework/graph/graph.hpp"

#include <cstdint>

namespace ockham {

/// Each pixel: S where its count is 1, else its sum over its count. Returns "radiance", rgba32f;
/// alpha is the share of the shaded samples that hit a surface.
ImageHandle add_resolve(
    Graph& graph, ImageHandle shaded_sum, ImageHandle first_sample, ImageHandle sample_count);

/// Every pixel has `k` samples in its sum.
ImageHandle add_resolve_uniform(Graph& graph, ImageHandle shaded_sum, std::uint32_t k);

} // namespace ockham

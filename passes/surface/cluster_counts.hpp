// SPDX-License-Identifier: Apache-2.0
// Counts that ask only how many surfaces a pixel sees: baselines that look at no colour.
#pragma once

#include "framework/graph/graph.hpp"

#include <cstdint>
#include <string>

namespace ockham {

struct ClusterCountsParams {
    std::uint32_t samples = 1; ///< n, 1 ... 64
    std::uint32_t single = 1;  ///< k of a pixel with one surface, 1 ... n
    std::uint32_t several = 0; ///< k of the others; 0: one for each surface
};

/// `labels`: of add_clusters(). Returns "sample_count", r8ui.
ImageHandle add_cluster_counts(
    Graph& graph, ImageHandle labels, const ClusterCountsParams& params, const std::string& reason);

} // namespace ockham

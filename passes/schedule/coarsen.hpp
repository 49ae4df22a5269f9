// SPDX-License-Identifier: Apache-2.0
// Coarser sample counts: one count per block of pixels, or powers of two only (Hollaender et al.
// 2013, section 4.2). Fewer, larger groups of equal work, paid for with more samples. Present only
// when asked for.
#pragma once

#include "framework/graph/graph.hpp"

#include <cstdint>

namespace ockham {

struct CoarsenParams {
    std::uint32_t width = 0, height = 0; ///< of the count image
    std::uint32_t n = 1;                 ///< largest count, 1 ... 64
    std::uint32_t block = 1;             ///< pixels per block and axis, 1 ... 64: its largest count
    bool powers_of_two = false;          ///< rounds counts up to 1, 2, 4, ..., n; n stays
};

/// True if counts of these parameters can be `k`, 1 ... n.
constexpr bool is_count_level(std::uint32_t k, bool powers_of_two, std::uint32_t n) {
    return !powers_of_two || k == n || (k & (k - 1)) == 0;
}

/// `sample_count`: r8ui, values 1 ... n. Returns an image like it, "coarse_count", nowhere smaller.
ImageHandle add_coarsen(Graph& graph, ImageHandle sample_count, const CoarsenParams& params);

} // namespace ockham

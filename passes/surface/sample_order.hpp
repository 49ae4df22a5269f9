// SPDX-License-Identifier: Apache-2.0
// In which order the samples of a window are taken, so that the first k, for every k, cover half a
// pixel cut by a straight edge as truly as they can. docs/sample_orders.md has the errors.
#pragma once

#include <cstdint>
#include <vector>

namespace ockham {

enum class SampleOrder {
    paper,   ///< the printed index matrices (Hollaender et al. 2013, figure 3)
    optimal, ///< least rms error of the coverage, summed over k
    worst,   ///< least of the worst errors, summed over k
};

/// List: i-th sample taken -> place in the window, row-major. `m`: 1 ... 8. paper: m = 1 ... 4, and
/// 8 by Bayer's recursion; worst: m = 1 ... 4; throws Error(input) for other m.
std::vector<std::uint32_t> sample_order(SampleOrder order, int m);

} // namespace ockham

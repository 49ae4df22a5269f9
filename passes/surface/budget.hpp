// SPDX-License-Identifier: Apache-2.0
// Samples for pixels, from the variance that their colours are expected to have, for a fixed share
// of all samples: finds allocate's lambda on the device, by a histogram, and splits what is left
// over in the order of the pixels. Nothing is read back, and the same picture gives the same
// counts.
#pragma once

#include "passes/surface/allocate.hpp"

namespace ockham {

struct BudgetParams {
    std::uint32_t samples = 1; ///< n, 1 ... 64
    double percent = 100;      ///< of all samples, 100 / n ... 100
    bool winner = false;       ///< also write what asked for the samples
};

/// `variance` as for add_allocate, up to 2^32 samples in all. Takes floor(percent of them), or less
/// if every pixel with any variance has n. Throws Error(input) for a percentage out of range.
Allocation add_budget(Graph& graph, ImageHandle variance, const BudgetParams& params);

} // namespace ockham

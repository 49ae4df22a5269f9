// SPDX-License-Identifier: Apache-2.0
// Tests of distributions: how well counts agree with what was expected.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace ockham::test {

/// Pearson's chi-squared as a standard normal variable (Wilson and Hilferty 1931): compare it with
/// z_limit(). `expected` are positive and sum to what `counts` sum to; those below 10 are put
/// together with their neighbours. Infinite where counts stand in nothing but empty bins.
inline double chi_squared_z(
    const std::vector<std::uint64_t>& counts, const std::vector<double>& expected) {
    double sum = 0, count = 0, mean = 0;
    std::size_t bins = 0;
    for (std::size_t i = 0; i < counts.size(); ++i) {
        count += static_cast<double>(counts[i]);
        mean += expected[i];
        const bool last = i + 1 == counts.size();
        if (mean < 10 && !last) continue;
        if (mean > 0) {
            sum += (count - mean) * (count - mean) / mean;
            ++bins;
        } else if (count > 0) {
            return std::numeric_limits<double>::infinity();
        }
        count = mean = 0;
    }
    const double freedom = static_cast<double>(bins) - 1, spread = 2 / (9 * freedom);
    return (std::cbrt(sum / freedom) - (1 - spread)) / std::sqrt(spread);
}

} // namespace ockham::test

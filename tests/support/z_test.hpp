// SPDX-License-Identifier: Apache-2.0
// Tests of expectations: how far a mean may lie from what it should be before chance is no excuse.
#pragma once

#include <cmath>
#include <cstddef>
#include <numbers>

namespace ockham::test {

/// Two-sided bound for each of `comparisons` independent standard normal variables, such that all
/// hold with probability 0.99 (Sidak 1967).
inline double z_limit(std::size_t comparisons) {
    const double alpha = 1 - std::pow(1 - 0.01, 1.0 / static_cast<double>(comparisons));
    double low = 0, high = 20;
    for (int i = 0; i < 100; ++i) {
        const double z = 0.5 * (low + high);
        (std::erfc(z / std::numbers::sqrt2) > alpha ? low : high) = z;
    }
    return high;
}

/// A mean and its standard error.
struct Estimate {
    double mean = 0, error = 0;
};

/// Distance in standard errors; infinite where exact values differ.
inline double z_of(const Estimate& a, const Estimate& b) {
    const double error = std::hypot(a.error, b.error);
    const double distance = std::abs(a.mean - b.mean);
    return distance == 0 ? 0 : distance / error;
}
inline double z_of(const Estimate& a, double truth) { return z_of(a, Estimate{truth, 0}); }

} // namespace ockham::test

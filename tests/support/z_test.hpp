// SPDX-License-Identifier: Apache-2.0
// Tests of expectations: how far a mean may lie from what it should be before chance is no excuse.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

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

/// Kolmogorov and Smirnov's distance of numbers from the uniform distribution on [0, 1].
inline double distance_from_uniform(std::vector<double> numbers) {
    std::sort(numbers.begin(), numbers.end());
    const auto n = static_cast<double>(numbers.size());
    double distance = 0;
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        const auto below = static_cast<double>(i);
        distance = std::max({distance, numbers[i] - below / n, (below + 1) / n - numbers[i]});
    }
    return distance;
}
/// Bound of that distance which holds with probability 0.99 for n numbers (Stephens 1970).
inline double kolmogorov_limit(std::size_t n) {
    const double root = std::sqrt(static_cast<double>(n));
    return 1.628 / (root + 0.12 + 0.11 / root);
}

} // namespace ockham::test

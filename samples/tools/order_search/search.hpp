// SPDX-License-Identifier: Apache-2.0
// Orders of a window's m x m samples, judged by how well the first k, for every k, cover half of a
// pixel cut by a straight edge. All edges that cross the pixel count alike (measure d-theta dd).
// An order lists places in the window, row-major, as passes/surface/frame.hpp does.
#pragma once

#include <cstdint>
#include <vector>

namespace ockham::order_search {

using Order = std::vector<std::uint32_t>;

/// Covered share of the pixel as the mean of some samples, minus the true one.
struct CoverageError {
    double rms = 0;
    double worst = 0; ///< of any edge
};

/// Errors of sets of samples, over `angles` directions of the edge and all its offsets.
class Judge {
public:
    /// `m`: 1 ... 8.
    explicit Judge(int m, int angles = 1440);

    std::uint32_t samples() const { return n_; }
    /// By ranks: [k - 1] is the error of the first k.
    std::vector<CoverageError> judge(const Order& order) const;
    /// `set`: bit i is the sample at place i; not empty.
    double worst(std::uint64_t set) const;

    // The mean square error of a set S of k samples is quadratic in its indicator:
    //   sum over i, j in S of pair(i, j) / k^2 - 2 sum over i in S of single(i) / k + square()
    double pair(std::uint32_t i, std::uint32_t j) const { return pair_[i * n_ + j]; }
    double single(std::uint32_t i) const { return single_[i]; }
    double square() const { return square_; }
    double rms(double pair_sum, double single_sum, std::uint32_t k) const;

private:
    /// The pixel seen along one direction: samples by their offset, and the area before each.
    struct Direction {
        std::vector<std::uint32_t> place; ///< ascending offset
        std::vector<double> area;         ///< share of the pixel with a smaller offset
    };

    std::uint32_t n_;
    std::vector<Direction> directions_;
    std::vector<double> pair_, single_;
    double square_ = 0;
};

enum class Goal {
    rms,   ///< least sum over k of the rms error
    worst, ///< least sum over k of the worst error
};

/// The best order there is: a dynamic program over all 2^n sets. m <= 4.
Order best_order(const Judge& judge, Goal goal);

/// A good order for the rms error, m <= 8: simulated annealing over exchanges of two ranks, that
/// also demands to be no worse at any k than each of `bars`.
Order anneal_order(
    const Judge& judge, const std::vector<Order>& bars, std::uint64_t seed, std::uint32_t steps);

/// Void-and-cluster (Ulichney 1993) on a torus, as an order.
Order void_and_cluster(int m);

} // namespace ockham::order_search

// SPDX-License-Identifier: Apache-2.0
#include "passes/surface/sample_order.hpp"

#include "framework/core/error.hpp"

namespace ockham {
namespace {

using Order = std::vector<std::uint32_t>;

/// Matrix of ranks (the sample at row-major place p is taken rank-th) to list of places by rank.
Order places_by_rank(const Order& ranks) {
    Order places(ranks.size());
    for (std::uint32_t place = 0; place < ranks.size(); ++place) places[ranks[place]] = place;
    return places;
}

/// Twice the size: each quadrant repeats the matrix, shifted by the 2 x 2 order [0 2; 3 1].
Order bayer_ranks(std::uint32_t m) {
    Order ranks{0};
    for (std::uint32_t size = 1; size < m; size *= 2) {
        Order next(4 * ranks.size());
        constexpr std::uint32_t quadrant[2][2] = {{0, 2}, {3, 1}};
        for (std::uint32_t y = 0; y < 2 * size; ++y) {
            for (std::uint32_t x = 0; x < 2 * size; ++x) {
                next[y * 2 * size + x] =
                    4 * ranks[(y % size) * size + x % size] + quadrant[y / size][x / size];
            }
        }
        ranks = std::move(next);
    }
    return ranks;
}

Order paper_ranks(int m) {
    switch (m) {
    case 1:
        return {0};
    case 2:
        return {0, 2, 3, 1};
    case 3:
        return {2, 6, 3, 5, 0, 8, 1, 7, 4};
    case 4:
        return {1, 8, 2, 10, 12, 4, 14, 6, 3, 11, 0, 9, 15, 7, 13, 5};
    case 8:
        return bayer_ranks(8);
    default:
        fail_input("--order paper: m = {} has no printed matrix; use m = 1, 2, 3, 4 or 8, or "
                   "--order optimal",
            m);
    }
}

// What order_search (samples/tools) finds; its test searches again.
Order optimal_ranks(int m) {
    switch (m) {
    case 1:
    case 2:
        return paper_ranks(m); // is optimal
    case 3:
        return {3, 7, 1, 5, 0, 6, 2, 8, 4};
    case 4:
        return {5, 11, 3, 13, 14, 0, 8, 6, 9, 7, 15, 1, 2, 12, 4, 10};
    case 5:
        return {12, 5, 22, 8, 19, 20, 15, 0, 14, 3, 2, 7, 17, 24, 11, 10, 23, 9, 1, 16, 18, 4, 13,
            21, 6};
    case 6:
        return {17, 28, 8, 24, 2, 21, 5, 12, 35, 14, 32, 10, 31, 20, 0, 26, 6, 30, 22, 9, 27, 13,
            19, 16, 3, 33, 18, 1, 34, 4, 15, 25, 7, 29, 11, 23};
    case 7:
        return {11, 42, 22, 8, 38, 31, 14, 34, 3, 28, 47, 18, 5, 44, 24, 40, 16, 0, 33, 21, 26, 6,
            19, 35, 48, 13, 41, 2, 45, 30, 9, 25, 7, 29, 36, 15, 1, 43, 20, 39, 17, 10, 27, 37, 12,
            32, 4, 46, 23};
    case 8:
        return {26, 57, 14, 41, 5, 47, 19, 35, 38, 2, 51, 22, 61, 28, 59, 10, 16, 45, 31, 32, 12,
            43, 1, 53, 54, 7, 63, 8, 55, 17, 37, 23, 24, 34, 20, 39, 27, 44, 6, 49, 50, 11, 48, 0,
            52, 13, 62, 30, 4, 60, 29, 58, 21, 33, 3, 40, 42, 18, 36, 9, 46, 25, 56, 15};
    default:
        check(false, "windows are 1 to 8 samples wide");
        return {};
    }
}

Order worst_ranks(int m) {
    switch (m) {
    case 1:
    case 2:
        return paper_ranks(m);
    case 3:
        return {7, 4, 2, 1, 0, 5, 6, 3, 8};
    case 4:
        return {2, 10, 6, 12, 8, 14, 0, 4, 5, 1, 15, 9, 13, 7, 11, 3};
    default:
        fail_input("--order worst: m = {} is too wide to be searched; use m = 1 ... 4, or --order "
                   "optimal",
            m);
    }
}

} // namespace

Order sample_order(SampleOrder order, int m) {
    switch (order) {
    case SampleOrder::paper:
        return places_by_rank(paper_ranks(m));
    case SampleOrder::worst:
        return places_by_rank(worst_ranks(m));
    case SampleOrder::optimal:
        break;
    }
    return places_by_rank(optimal_ranks(m));
}

} // namespace ockham

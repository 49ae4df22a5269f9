// SPDX-License-Identifier: Apache-2.0
#include "framework/core/rng.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace ockham {
namespace {

/// The published check values of PCG32 with seed 42 and stream 54 (pcg-random.org, demo program).
TEST(Rng, equals_the_published_sequence) {
    Pcg32 rng(42, 54);
    for (const std::uint32_t expected :
        {0xa15c02b7u, 0x7b47f409u, 0xba1d3330u, 0x83d2f293u, 0xbfa4784bu, 0xcbed606eu}) {
        EXPECT_EQ(rng.next(), expected);
    }
}

/// Chi-squared over 64 bins, 63 degrees of freedom: 103.4 is the 99.9 % quantile.
TEST(Rng, is_uniform) {
    Pcg32 rng(1);
    std::array<int, 64> bins{};
    constexpr int kDraws = 64000;
    for (int i = 0; i < kDraws; ++i) {
        const float u = rng.uniform();
        ASSERT_GE(u, 0.0f);
        ASSERT_LT(u, 1.0f);
        ++bins[static_cast<std::size_t>(u * 64.0f)];
    }
    double chi2 = 0;
    for (const int count : bins) chi2 += std::pow(count - kDraws / 64.0, 2) / (kDraws / 64.0);
    EXPECT_LT(chi2, 103.4);
}

TEST(Rng, below_stays_below) {
    Pcg32 rng(2);
    for (int i = 0; i < 1000; ++i) EXPECT_LT(rng.below(7), 7u);
}

} // namespace
} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
// Limits on synthetic samples: the counts against brute force, the law behind them against all
// orders of drawing, and the curves' ends.
#include "framework/core/rng.hpp"
#include "framework/image_error/mse.hpp"
#include "samples/chart/aa_limits.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

namespace ockham {
namespace {

TEST(AaLimitsTest, VarianceCountIsTheMinimum) {
    Pcg32 rng(7);
    for (const std::uint32_t n : {1u, 2u, 4u, 9u, 16u, 64u}) {
        for (int i = 0; i < 2000; ++i) {
            const double variance = std::exp(-12.0 * double{rng.uniform()});
            const double lambda = std::exp(-14.0 * double{rng.uniform()});
            const auto cost = [&](std::uint32_t k) {
                const double left = n == 1 ? 0.0 : variance / k * (n - k) / (n - 1);
                return left + lambda * k;
            };
            std::uint32_t best = 1;
            for (std::uint32_t k = 2; k <= n; ++k)
                if (cost(k) < cost(best)) best = k;
            ASSERT_EQ(variance_count(variance, n, lambda), best)
                << "variance " << variance << ", lambda " << lambda << ", n " << n;
        }
        EXPECT_EQ(variance_count(0.0, n, 0.0), 1u) << "equal samples need one";
        EXPECT_EQ(variance_count(0.1, n, 0.0), n);
        EXPECT_EQ(variance_count(0.1, n, std::numeric_limits<double>::infinity()), 1u);
    }
}

TEST(AaLimitsTest, ClairvoyantCountTakesTheSmallestOfEquals) {
    const std::array<float, 4> error{0.5f, 0.1f, 0.1f, 0.0f};
    EXPECT_EQ(clairvoyant_count(error, 0.0), 4u);
    EXPECT_EQ(clairvoyant_count(error, 0.06), 2u);
    EXPECT_EQ(clairvoyant_count(error, 0.4), 1u) << "0.5 + 0.4 = 0.1 + 0.8";
    EXPECT_EQ(clairvoyant_count(std::array<float, 3>{}, 0.0), 1u);
}

/// All orders of four samples: the mean of the first k misses the mean of all by
/// variance / k * (n - k) / (n - 1), on average exactly.
TEST(AaLimitsTest, TheLawIsTheMeanErrorOverAllOrders) {
    const std::array<double, 4> value{0.1, 0.9, 0.35, 0.5};
    const double mean = (0.1 + 0.9 + 0.35 + 0.5) / 4;
    double variance = 0;
    for (const double v : value) variance += (v - mean) * (v - mean) / 4;
    for (int k = 1; k <= 4; ++k) {
        std::array<std::size_t, 4> order{0, 1, 2, 3};
        double sum = 0;
        int orders = 0;
        do {
            double part = 0;
            for (int i = 0; i < k; ++i) part += value[order[std::size_t(i)]];
            sum += (part / k - mean) * (part / k - mean);
            ++orders;
        } while (std::next_permutation(order.begin(), order.end()));
        EXPECT_NEAR(sum / orders, variance / k * (4 - k) / 3, 1e-15) << k;
    }
}

/// Pictures of displayed greys from per-sample values [pixel][sample]: means in linear light.
class Synthetic {
public:
    static constexpr std::uint32_t kN = 4;
    static constexpr int kWidth = 40, kHeight = 30;
    Synthetic() : samples(2 * kWidth, 2 * kHeight, {"R", "G", "B"}) {
        Pcg32 rng(3);
        for (int y = 0; y < kHeight; ++y) {
            for (int x = 0; x < kWidth; ++x) {
                const float spread = x < kWidth / 2 ? 0.0f : 0.4f * rng.uniform();
                for (int i = 0; i < 4; ++i) {
                    const float v = srgb_decode(0.3f + spread * rng.uniform());
                    for (int c = 0; c < 3; ++c) samples.at(2 * x + i % 2, 2 * y + i / 2, c) = v;
                }
            }
        }
    }
    Image picture(int k) const {
        Image result(kWidth, kHeight, {"R", "G", "B"});
        for (int c = 0; c < 3; ++c) {
            for (int y = 0; y < kHeight; ++y) {
                for (int x = 0; x < kWidth; ++x) {
                    float sum = 0;
                    for (int i = 0; i < k; ++i) sum += samples.at(2 * x + i % 2, 2 * y + i / 2, c);
                    result.at(x, y, c) = sum / static_cast<float>(k);
                }
            }
        }
        return result;
    }
    Image samples;
};

TEST(AaLimitsTest, CurvesRunFromOneSampleToAllAndClairvoyanceWins) {
    const Synthetic scene;
    AaLimits limits(scene.picture(4), 4);
    for (int k = 1; k < 4; ++k) limits.add(static_cast<std::uint32_t>(k), scene.picture(k));
    const std::vector<float> variance = sample_variance(scene.samples, 2);
    for (std::size_t i = 0; i < variance.size(); ++i) {
        const bool flat = i % Synthetic::kWidth < Synthetic::kWidth / 2;
        ASSERT_EQ(variance[i] < 1e-12f, flat) << i;
    }

    const LimitPoint all = limits.by_variance(variance, 0.0);
    EXPECT_EQ(all.samples_percent, 62.5) << "half of the pixels are flat and take one of four";
    EXPECT_LT(all.mse, 1e-12);
    const double infinite = std::numeric_limits<double>::infinity();
    const LimitPoint one = limits.by_variance(variance, infinite);
    EXPECT_EQ(one.samples_percent, 25.0);
    EXPECT_NEAR(one.mse, limits.by_clairvoyance(1e9).mse, 1e-12);
    EXPECT_DOUBLE_EQ(one.psnr, psnr(one.mse));

    double samples = 101, error = -1;
    for (double lambda = 1e-6; lambda < 0.1; lambda *= 1.5) {
        const LimitPoint v = limits.by_variance(variance, lambda);
        const LimitPoint c = limits.by_clairvoyance(lambda);
        EXPECT_LE(c.mse + lambda * c.samples_percent * 0.04,
            v.mse + lambda * v.samples_percent * 0.04 + 1e-12)
            << lambda;
        EXPECT_LE(v.samples_percent, samples);
        EXPECT_GE(c.mse, error) << "dearer samples, more error";
        samples = v.samples_percent;
        error = c.mse;
    }
}

} // namespace
} // namespace ockham

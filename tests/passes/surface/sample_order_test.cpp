// SPDX-License-Identifier: Apache-2.0
// Sample orders: searched again where all sets can be visited, judged again beyond.
#include "passes/surface/sample_order.hpp"
#include "samples/tools/order_search/search.hpp"
#include "tests/support/gpu_fixture.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace ockham::test {
namespace {

using namespace order_search;

double sum(const std::vector<CoverageError>& errors, double CoverageError::*which) {
    double total = 0;
    for (const CoverageError& e : errors) total += e.*which;
    return total;
}

TEST(SampleOrderTest, OrdersArePermutations) {
    for (const SampleOrder kind : {SampleOrder::paper, SampleOrder::optimal, SampleOrder::worst}) {
        for (int m = 1; m <= 8; ++m) {
            if (kind != SampleOrder::optimal && m > 4 && !(kind == SampleOrder::paper && m == 8))
                continue;
            std::vector<std::uint32_t> order = sample_order(kind, m), all(order.size());
            ASSERT_EQ(order.size(), static_cast<std::size_t>(m * m));
            std::iota(all.begin(), all.end(), 0u);
            std::sort(order.begin(), order.end());
            EXPECT_EQ(order, all) << "m = " << m;
        }
    }
}

TEST(SampleOrderTest, WidthsWithoutAnOrderAreRefusedInWords) {
    for (const int m : {5, 6, 7}) {
        const std::string text = error_of([&] { sample_order(SampleOrder::paper, m); });
        EXPECT_NE(text.find("no printed matrix"), std::string::npos) << text;
    }
    for (const int m : {5, 6, 7, 8}) {
        const std::string text = error_of([&] { sample_order(SampleOrder::worst, m); });
        EXPECT_NE(text.find("use m = 1 ... 4, or --order optimal"), std::string::npos) << text;
    }
}

TEST(SampleOrderTest, JudgeKnowsOneSampleAndAgreesWithCountingOnFineGrids) {
    const Judge one(1);
    // A sample in the middle: the error is the smaller part of the pixel, at most one half.
    EXPECT_NEAR(one.judge({0})[0].worst, 0.5, 1e-6);

    // The same mean over edges, by brute force over offsets.
    const int m = 3, angles = 45, offsets = 1000;
    const Judge judge(m, angles);
    const std::vector<std::uint32_t> order = sample_order(SampleOrder::paper, m);
    const std::vector<CoverageError> errors = judge.judge(order);
    std::vector<double> square(order.size()), worst(order.size());
    double measure = 0;
    for (int a = 0; a < angles; ++a) {
        const double angle = 3.14159265358979 * (a + 0.5) / angles;
        const double c = std::cos(angle), s = std::sin(angle);
        const double reach = 0.5 * (std::abs(c) + std::abs(s));
        for (int o = 0; o < offsets; ++o) {
            const double d = reach * (2.0 * (o + 0.5) / offsets - 1.0);
            // Area before the edge: strips of the square, each an interval.
            double area = 0;
            constexpr int kStrips = 512;
            for (int i = 0; i < kStrips; ++i) {
                const double y = (i + 0.5) / kStrips - 0.5, x = (d - y * s) / c;
                area += std::clamp(c > 0 ? x + 0.5 : 0.5 - x, 0.0, 1.0) / kStrips;
            }
            double covered = 0;
            for (std::size_t k = 1; k <= order.size(); ++k) {
                const double x = (order[k - 1] % m + 0.5) / m - 0.5;
                const double y = (order[k - 1] / m + 0.5) / m - 0.5;
                covered += x * c + y * s < d ? 1.0 : 0.0;
                const double error = covered / static_cast<double>(k) - area;
                square[k - 1] += error * error * reach;
                worst[k - 1] = std::max(worst[k - 1], std::abs(error));
            }
            measure += reach;
        }
    }
    for (std::size_t k = 0; k < order.size(); ++k) {
        EXPECT_NEAR(errors[k].rms, std::sqrt(square[k] / measure), 5e-4) << "k = " << k + 1;
        EXPECT_NEAR(errors[k].worst, worst[k], 5e-3) << "k = " << k + 1;
    }
}

TEST(SampleOrderTest, JudgeFindsTheKnownErrorsOfThePrintedMatrix) {
    // Of an independent computation.
    const double rms[] = {0.273, 0.192, 0.176, 0.140, 0.139, 0.086, 0.075, 0.053};
    const std::vector<CoverageError> errors = Judge(4).judge(sample_order(SampleOrder::paper, 4));
    for (std::size_t k = 0; k < 8; ++k) EXPECT_NEAR(errors[k].rms, rms[k], 1e-3) << "k = " << k + 1;
}

TEST(SampleOrderTest, NoOrderIsBetterUpToFourByFour) {
    for (int m = 1; m <= 4; ++m) {
        const Judge judge(m);
        EXPECT_NEAR(sum(judge.judge(sample_order(SampleOrder::optimal, m)), &CoverageError::rms),
            sum(judge.judge(best_order(judge, Goal::rms)), &CoverageError::rms), 1e-9)
            << "m = " << m;
        // Worst errors are searched over fewer edges: 65,536 sets times all samples of each.
        const Judge coarse(m, 360);
        EXPECT_NEAR(sum(coarse.judge(sample_order(SampleOrder::worst, m)), &CoverageError::worst),
            sum(coarse.judge(best_order(coarse, Goal::worst)), &CoverageError::worst), 1e-9)
            << "m = " << m;
    }
}

TEST(SampleOrderTest, WiderOrdersAreNoWorseThanBayerOrVoidAndClusterAtAnyCount) {
    for (int m = 5; m <= 8; ++m) {
        const Judge judge(m);
        const std::vector<CoverageError> ours = judge.judge(sample_order(SampleOrder::optimal, m));
        std::vector<std::vector<std::uint32_t>> bars{void_and_cluster(m)};
        if (m == 8) bars.push_back(sample_order(SampleOrder::paper, m));
        for (const std::vector<std::uint32_t>& bar : bars) {
            const std::vector<CoverageError> theirs = judge.judge(bar);
            for (std::size_t k = 0; k < ours.size(); ++k)
                EXPECT_LE(ours[k].rms, theirs[k].rms + 1e-9) << "m = " << m << ", k = " << k + 1;
            EXPECT_LT(sum(ours, &CoverageError::rms), 0.8 * sum(theirs, &CoverageError::rms));
        }
    }
}

TEST(SampleOrderTest, AnnealingFindsTheOptimumWhereItIsKnown) {
    const Judge judge(3);
    const order_search::Order found =
        anneal_order(judge, {sample_order(SampleOrder::paper, 3)}, 1, 20000);
    EXPECT_NEAR(sum(judge.judge(found), &CoverageError::rms),
        sum(judge.judge(sample_order(SampleOrder::optimal, 3)), &CoverageError::rms), 0.01);
}

} // namespace
} // namespace ockham::test

// SPDX-License-Identifier: Apache-2.0
// Samples for a budget: exactly as many as asked for, to whom they help most, whatever the
// variances look like.
#include "framework/core/rng.hpp"
#include "passes/surface/budget.hpp"
#include "tests/reference/allocate.hpp"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/pass_bench.hpp"

#include <cmath>
#include <functional>
#include <limits>
#include <numeric>

namespace ockham::test {
namespace {

using Variances = std::vector<glm::vec2>;
using Counts = std::vector<std::uint8_t>;

class BudgetTest : public GpuTest {
protected:
    static Counts spend(const Variances& variance, std::uint32_t width, std::uint32_t n,
        double percent, int executions = 1) {
        PassBench bench(device());
        const auto height = static_cast<std::uint32_t>(variance.size()) / width;
        const ImageHandle image =
            bench.image("variance", VK_FORMAT_R32G32_SFLOAT, width, height, variance);
        const ImageHandle k = bench.keep(
            add_budget(bench.graph, image, {.samples = n, .percent = percent}).sample_count);
        for (int i = 0; i < executions; ++i) bench.execute();
        return bench.texels<std::uint8_t>(k);
    }
    static std::uint64_t total(const Counts& k) {
        return std::accumulate(k.begin(), k.end(), std::uint64_t{0});
    }
    /// What even the lowest price buys.
    static std::uint64_t most(const Variances& variance, std::uint32_t n) {
        std::uint64_t sum = 0;
        for (const glm::vec2 v : variance)
            sum += v.x > 0 ? n : v.y > 0 ? std::min(reference::surface_count(v), n) : 1u;
        return sum;
    }
    /// A budget is met to the sample, unless nothing is left to buy.
    static void expect_met(const Variances& variance, std::uint32_t width, std::uint32_t n) {
        const double floor = 100.0 / n, all = static_cast<double>(variance.size()) * n;
        for (const double percent :
            {floor, floor + 0.3, floor + 2, floor + 10, 50.0, 90.0, 99.99, 100.0}) {
            if (percent > 100 || percent < floor) continue;
            const Counts k = spend(variance, width, n, percent);
            for (const std::uint8_t count : k) ASSERT_TRUE(count >= 1 && count <= n);
            const auto target = static_cast<std::uint64_t>(percent / 100 * all + 1e-6);
            EXPECT_EQ(total(k),
                std::min(std::max<std::uint64_t>(target, variance.size()), most(variance, n)))
                << percent << " % of " << n;
        }
    }
    /// Zeros, the same value over and over, and all magnitudes; some with several surfaces.
    static Variances random(std::size_t pixels, std::uint64_t seed) {
        Pcg32 rng(seed);
        Variances out;
        for (std::size_t i = 0; i < pixels; ++i) {
            const auto draw = [&] {
                const std::uint32_t kind = rng.below(4);
                return kind == 0   ? 0.0f
                       : kind == 1 ? 0.01f
                       : kind == 2 ? std::exp(rng.uniform(-20.0f, 0.0f))
                                   : std::exp(rng.uniform(-80.0f, 0.0f));
            };
            out.push_back(reference::pack_variance(draw(), draw(), 1 + rng.below(4)));
        }
        return out;
    }
};

TEST_F(BudgetTest, IsMetToTheSample) {
    for (const std::uint32_t n : {4u, 9u, 16u, 64u}) expect_met(random(7 * 61, n), 7, n);
    expect_met(random(256 * 192, 5), 256, 16);
}

TEST_F(BudgetTest, IsMetWhereAllPixelsAreAlike) {
    for (const float variance : {1.2e-38f, 1e-12f, 0.01f, 0.25f})
        expect_met(Variances(32 * 32, {variance, 0.0f}), 32, 16);
    expect_met(Variances(32 * 32, reference::pack_variance(0.0f, 0.1f, 4)), 32, 16);
    expect_met(Variances(32 * 32, {0.0f, 0.0f}), 32, 16);
    expect_met({{0.1f, 0.0f}}, 1, 16);
}

TEST_F(BudgetTest, SplitsTiesInTheOrderOfPixels) {
    const Counts k = spend(Variances(64, {0.01f, 0.0f}), 8, 16, 100.0 / 16 * (1 + 20.0 / 64));
    for (std::size_t i = 0; i < k.size(); ++i) EXPECT_EQ(k[i], i < 20 ? 2 : 1) << i;
}

TEST_F(BudgetTest, IsAllocationAtOnePrice) {
    // At some lambda every pixel has what allocate gives it, but for the rounding of variances to
    // sixteen steps an octave and for what is left over.
    const Variances variance = random(128 * 96, 3);
    for (const double percent : {8.0, 15.0, 40.0}) {
        const Counts k = spend(variance, 128, 16, percent);
        double low = 1e-40, high = 1; // price, by bisection
        for (int i = 0; i < 60; ++i) {
            const double lambda = std::sqrt(low * high);
            std::uint64_t sum = 0;
            for (const glm::vec2 v : variance) sum += reference::allocated_samples(v, lambda, 16);
            (sum > total(k) ? low : high) = lambda;
        }
        for (std::size_t i = 0; i < k.size(); ++i) {
            EXPECT_LE(k[i], reference::allocated_samples(variance[i], high / 1.15, 16)) << i;
            EXPECT_GE(k[i], reference::allocated_samples(variance[i], high * 1.15, 16)) << i;
        }
    }
}

TEST_F(BudgetTest, ExecutionsAgree) {
    const Variances variance = random(64 * 64, 9);
    EXPECT_EQ(spend(variance, 64, 16, 20), spend(variance, 64, 16, 20, 3));
}

TEST_F(BudgetTest, LessThanASampleAPixelIsRefusedByTheFloor) {
    const auto refused = [](std::uint32_t n, double percent) {
        return error_of([&] { spend(Variances(4), 2, n, percent); });
    };
    EXPECT_NE(refused(16, 6.2).find("at least 6.25 %"), std::string::npos) << refused(16, 6.2);
    EXPECT_NE(refused(9, 11.1).find("at least 11.12 %"), std::string::npos);
    EXPECT_NE(refused(16, 101).find("at most 100 %"), std::string::npos);
    EXPECT_NE(refused(16, std::numeric_limits<double>::quiet_NaN()), "");
    EXPECT_EQ(refused(16, 6.25), "");
}

} // namespace
} // namespace ockham::test

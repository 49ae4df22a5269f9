// SPDX-License-Identifier: Apache-2.0
// The law that turns variance into samples, against the integer minimiser found by trying.
#include "framework/core/rng.hpp"
#include "passes/surface/allocate.hpp"
#include "shaders/surface/metrics.h"
#include "tests/reference/allocate.hpp"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/pass_bench.hpp"

#include <cmath>
#include <limits>

namespace ockham::test {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

class AllocateTest : public GpuTest {
protected:
    struct Result {
        std::vector<std::uint8_t> k, winner;
    };
    static Result allocate(const std::vector<glm::vec2>& variance, AllocateParams params) {
        PassBench bench(device());
        const auto width = static_cast<std::uint32_t>(variance.size());
        const ImageHandle image =
            bench.image("variance", VK_FORMAT_R32G32_SFLOAT, width, 1, variance);
        params.winner = true;
        const Allocation out = add_allocate(bench.graph, image, params);
        const ImageHandle k = bench.keep(out.sample_count), winner = bench.keep(out.winner);
        bench.execute();
        return {bench.texels<std::uint8_t>(k), bench.texels<std::uint8_t>(winner)};
    }
};

TEST_F(AllocateTest, TakesTheIntegerThatMinimisesErrorAndPrice) {
    Pcg32 rng(1);
    for (const std::uint32_t n : {1u, 4u, 9u, 16u, 64u}) {
        const float lambda = 1e-4f;
        std::vector<glm::vec2> variance;
        for (int i = 0; i < 4000; ++i)
            variance.emplace_back(lambda * std::exp(rng.uniform(-2.0f, 9.0f)), 0.0f);
        const Result result = allocate(variance, {.samples = n, .lambda = lambda});
        for (std::size_t i = 0; i < variance.size(); ++i) {
            const auto cost = [&](std::uint32_t k) {
                return double{variance[i].x} / k + double{lambda} * k;
            };
            double least = cost(1);
            for (std::uint32_t k = 2; k <= n; ++k) least = std::min(least, cost(k));
            ASSERT_TRUE(result.k[i] >= 1 && result.k[i] <= n);
            // Where two counts cost the same, either will do.
            EXPECT_NEAR(cost(result.k[i]), least, 2e-6 * least) << variance[i].x << ", n = " << n;
        }
    }
}

TEST_F(AllocateTest, SurfacesGetASampleEachWhereTheyDiffer) {
    const float lambda = 0.01f;
    std::vector<glm::vec2> variance;
    std::vector<int> expected, winner;
    for (std::uint32_t surfaces = 1; surfaces <= 4; ++surfaces) {
        for (const float within : {0.0f, 0.021f, 0.3f}) {
            for (const float between : {0.0f, 0.0099f, 0.0101f, 0.2f}) {
                variance.push_back(reference::pack_variance(
                    within, between * static_cast<float>(surfaces - 1), surfaces));
                const int from_within = within == 0.0f ? 1 : within < 0.1f ? 2 : 6;
                const int from_surfaces = between > lambda ? static_cast<int>(surfaces) : 1;
                expected.push_back(std::max(from_within, from_surfaces));
                winner.push_back(
                    static_cast<int>(expected.back() == 1               ? WINNER_NONE
                                     : from_surfaces == expected.back() ? WINNER_SURFACES
                                                                        : WINNER_VARIATION));
            }
        }
    }
    const Result result = allocate(variance, {.samples = 16, .lambda = lambda});
    EXPECT_EQ(std::vector<int>(result.k.begin(), result.k.end()), expected);
    EXPECT_EQ(std::vector<int>(result.winner.begin(), result.winner.end()), winner);
}

TEST_F(AllocateTest, PricesOfZeroAndInfinity) {
    const std::vector<glm::vec2> variance{{0.0f, 0.0f}, {0.25f, 0.0f},
        reference::pack_variance(0.0f, 0.2f, 3), reference::pack_variance(0.25f, 0.2f, 4)};
    for (const std::uint32_t n : {1u, 4u, 64u}) {
        const auto all = static_cast<std::uint8_t>(n);
        EXPECT_EQ(allocate(variance, {.samples = n, .lambda = 0.0f}).k,
            std::vector<std::uint8_t>(4, all));
        EXPECT_EQ(allocate(variance, {.samples = n, .lambda = kInfinity}).k,
            std::vector<std::uint8_t>(4, 1));
    }
}

} // namespace
} // namespace ockham::test

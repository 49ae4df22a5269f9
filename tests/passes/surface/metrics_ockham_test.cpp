// SPDX-License-Identifier: Apache-2.0
// The default metric on synthetic windows, through clusters and allocate, beside the paper's: where
// the paper's fails, by its value, and what this one says there.
#include "framework/core/rng.hpp"
#include "passes/surface/allocate.hpp"
#include "passes/surface/metrics.hpp"
#include "passes/surface/metrics_ockham.hpp"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/surface_windows.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace ockham::test {
namespace {

class OckhamMetricsTest : public GpuTest {
protected:
    struct Result {
        std::vector<int> ockham, paper; ///< k
        std::vector<glm::vec2> variance;
    };
    /// Both metrics with their default constants.
    static Result measure(
        const SurfaceWindows& windows, float lambda = kDefaultLambda, bool stratified = true) {
        Result result;
        {
            PassBench bench(device());
            const BufferHandle frame = bench.buffer("frame", std::vector{windows.frame()});
            const Gbuffer gbuffer = windows.gbuffer(bench);
            const Clusters clusters = add_clusters(
                bench.graph, frame, gbuffer, {windows.width, windows.height, windows.m}, "test");
            const ImageHandle variance = add_ockham_metrics(bench.graph,
                {frame, gbuffer, clusters, first_sample(bench, windows)}, {windows.m, stratified});
            const Allocation out =
                add_allocate(bench.graph, variance, {.samples = windows.n(), .lambda = lambda});
            const ImageHandle kept = bench.keep(variance);
            bench.graph.export_resource(out.sample_count, "test");
            bench.execute();
            result.ockham = integers(bench.read(out.sample_count));
            result.variance = bench.texels<glm::vec2>(kept);
        }
        PassBench bench(device());
        const BufferHandle frame = bench.buffer("frame", std::vector{windows.frame()});
        MetricsParams params = default_metrics(windows.m);
        params.width = windows.width;
        params.height = windows.height;
        const Metrics out = add_metrics(
            bench.graph, {frame, windows.gbuffer(bench), first_sample(bench, windows)}, params);
        bench.graph.export_resource(out.sample_count, "test");
        bench.execute();
        result.paper = integers(bench.read(out.sample_count));
        return result;
    }
    static ImageHandle first_sample(PassBench& bench, const SurfaceWindows& windows) {
        return bench.image("S", VK_FORMAT_R32G32B32A32_SFLOAT, windows.width, windows.height,
            windows.first_sample);
    }
    static std::vector<int> integers(const Image& image) {
        const std::span<const float> plane = image.plane(0);
        return {plane.begin(), plane.end()};
    }
    static int largest(const std::vector<int>& k) { return *std::max_element(k.begin(), k.end()); }
    /// 3 x 3 pixels of grey 0.5 at depth 10; the samples of each have these normals in turn.
    static SurfaceWindows facets(std::uint32_t m, const std::vector<glm::vec3>& normals) {
        SurfaceWindows windows(3, 3, m);
        for (std::uint32_t y = 0; y < 3; ++y) {
            for (std::uint32_t x = 0; x < 3; ++x) {
                windows.set_luma(x, y, 0.5f);
                for (std::uint32_t i = 0; i < windows.n(); ++i)
                    windows.set(x, y, i, 10, normals[i % normals.size()]);
            }
        }
        return windows;
    }
    /// One plane that fills the picture, in grey 0.5: seen at `degrees`, `depth` away.
    static SurfaceWindows plane(double degrees, double depth) {
        SurfaceWindows windows(9, 9, 4);
        const double per_sample = 0.01 / 4 * std::tan(degrees * 3.14159265358979 / 180) / depth;
        for (std::uint32_t y = 0; y < 9; ++y) {
            for (std::uint32_t x = 0; x < 9; ++x) {
                windows.set_luma(x, y, 0.5f);
                for (std::uint32_t i = 0; i < 16; ++i) {
                    // Nowhere beyond the horizon: the last row is the farthest.
                    const double row = 4.0 * y + i / 4;
                    const double slope = std::min(per_sample, 0.9 / depth / 36);
                    windows.set(x, y, i, static_cast<float>(1 / (1 / depth - slope * row)),
                        {0, 0, 1}, 0, {0.0f, -static_cast<float>(slope)});
                }
            }
        }
        return windows;
    }
};

TEST_F(OckhamMetricsTest, PlanesTakeOneSampleAtAnyAngleDistanceAndScale) {
    int paper = 1;
    for (const double depth : {5.0, 50.0, 500.0, 5000.0}) {
        for (const double degrees : {0.0, 45.0, 60.0, 80.0, 85.0, 89.0, 89.9}) {
            const Result result = measure(plane(degrees, depth));
            EXPECT_EQ(result.ockham, std::vector<int>(81, 1)) << degrees << " at " << depth;
            paper = std::max(paper, largest(result.paper));
        }
    }
    EXPECT_EQ(paper, 16) << "the paper's depth variance asks for all samples of a plane";
}

TEST_F(OckhamMetricsTest, ConstantDepthHasNoVarianceWhateverItIs) {
    std::vector<float> distances;
    for (float z = 1.0f; z <= 1.0001e6f; z *= 1.5848932f) distances.push_back(z);
    SurfaceWindows windows(static_cast<std::uint32_t>(distances.size()), 1, 3);
    for (std::uint32_t x = 0; x < windows.width; ++x) {
        windows.set_luma(x, 0, 0.5f);
        for (std::uint32_t i = 0; i < 9; ++i) windows.set(x, 0, i, distances[x]);
    }
    const Result result = measure(windows);
    EXPECT_EQ(result.ockham, std::vector<int>(distances.size(), 1));
    EXPECT_EQ(result.variance, std::vector<glm::vec2>(distances.size(), glm::vec2(0.0f)));
    EXPECT_EQ(largest(result.paper), 9) << "rounding of the paper's sums";
}

TEST_F(OckhamMetricsTest, CoplanarMaterialsGetASampleEach) {
    SurfaceWindows windows(4, 4, 4);
    for (std::uint32_t y = 0; y < 4; ++y) {
        for (std::uint32_t x = 0; x < 4; ++x) {
            windows.set_luma(x, y, 0.5f);
            for (std::uint32_t i = 0; i < 16; ++i)
                windows.set(x, y, i, 8, {0, 0, 1}, (i + i / 4) % 2);
        }
    }
    const Result result = measure(windows);
    for (const int k : result.ockham) EXPECT_GE(k, 2);
    EXPECT_EQ(result.paper, std::vector<int>(16, 1)) << "the same depth, normal and S";
}

TEST_F(OckhamMetricsTest, CreasesFoldsAndNormalsAllAround) {
    const auto crease = [](double degrees) {
        const double half = 0.5 * glm::radians(degrees);
        return std::vector<glm::vec3>{
            {std::sin(half), 0, std::cos(half)}, {-std::sin(half), 0, std::cos(half)}};
    };
    const float s = std::sqrt(3.0f) / 2;
    EXPECT_EQ(largest(measure(facets(4, {{0, 0, 1}})).ockham), 1);
    EXPECT_GT(measure(facets(4, crease(90))).ockham[4], 1);
    EXPECT_GT(measure(facets(4, crease(10)), 1e-6f).ockham[4], 1) << "small, but never nothing";

    const Result fold = measure(facets(4, {{0, 0, 1}, {0, 0, -1}}));
    EXPECT_EQ(fold.ockham, std::vector<int>(9, 16));
    EXPECT_EQ(fold.paper, std::vector<int>(9, 1)) << "the paper's mean normal vanishes";
    const Result around = measure(facets(3, {{1, 0, 0}, {-0.5f, s, 0}, {-0.5f, -s, 0}}));
    EXPECT_EQ(around.ockham, std::vector<int>(9, 9));
}

TEST_F(OckhamMetricsTest, SkyTakesOneSampleAndSilhouettesOnePerSide) {
    for (const std::uint32_t m : {2u, 3u, 4u, 8u}) {
        SurfaceWindows windows(8, 8, m);
        EXPECT_EQ(measure(windows).ockham, std::vector<int>(64, 1)) << "m = " << m;
        for (std::uint32_t i = 1; i <= std::max(1u, windows.n() / 8); ++i) windows.set(3, 4, i, 20);
        const Result result = measure(windows);
        std::vector<int> expected(64, 1);
        expected[4 * 8 + 3] = 2;
        EXPECT_EQ(result.ockham, expected) << "m = " << m;
        EXPECT_EQ(result.paper[4 * 8 + 3], static_cast<int>(windows.n()));
    }
}

TEST_F(OckhamMetricsTest, APrefixAveragesSurfacesLikeAnythingElse) {
    // Half of the middle pixel shows a bright surface: one sample of each suffices where they are
    // weighed apart; a prefix of the samples has to find out how much of either there is.
    SurfaceWindows windows(3, 3, 4);
    for (std::uint32_t y = 0; y < 3; ++y) {
        for (std::uint32_t x = 0; x < 3; ++x) {
            windows.set_luma(x, y, x == 2 ? 0.9f : 0.1f);
            for (std::uint32_t i = 0; i < 16; ++i)
                windows.set(x, y, i, 10, {0, 0, 1}, x == 2 || (x == 1 && i % 4 > 1) ? 1 : 0);
        }
    }
    // Half at 0.1 and half at 0.9: a variance of 0.16.
    const Result prefix = measure(windows, 1e-3f, false), apart = measure(windows, 1e-3f);
    // Drawn towards the mean over 3 x 3 pixels, of which a column has this variance.
    EXPECT_NEAR(prefix.variance[4].x, 0.16f / std::cbrt(3.0f), 0.001f);
    EXPECT_EQ(prefix.variance[4].y, 0.0f);
    EXPECT_EQ(prefix.ockham[4], 11) << "floor(1/2 + sqrt(1/4 + 110.9))";
    EXPECT_EQ(apart.ockham[4], 2);
    EXPECT_EQ(prefix.ockham[3], 1);
}

TEST_F(OckhamMetricsTest, StepsOfLumaHaveNoDeadZone) {
    // Five rows of three pixels for each step, on one surface; S steps by r to the right of the
    // middle.
    constexpr std::uint32_t kSteps = 41;
    for (const float base : {0.1f, 0.3f, 0.6f}) {
        SurfaceWindows windows(3, 5 * kSteps, 4);
        windows.fill(10);
        for (std::uint32_t y = 0; y < windows.height; ++y) {
            const float r = 0.2f * static_cast<float>(y / 5) / (kSteps - 1);
            for (std::uint32_t x = 0; x < 3; ++x) windows.set_luma(x, y, x == 2 ? base + r : base);
        }
        const Result result = measure(windows);
        float before = 0, ratio = 0;
        for (std::uint32_t step = 0; step < kSteps; ++step) {
            const std::size_t middle = (5 * step + 2) * 3 + 1;
            const float r = 0.2f * static_cast<float>(step) / (kSteps - 1);
            const float variance = result.variance[middle].x;
            if (step == 0) {
                EXPECT_LT(variance, 1e-10f);
                continue;
            }
            EXPECT_GT(variance, before) << "step " << r;
            if (ratio == 0) ratio = variance / (r * r);
            EXPECT_NEAR(variance / (r * r), ratio, 1e-2f * ratio) << "grows with the square";
            before = variance;
        }
        EXPECT_EQ(result.paper[(5 * 5 + 2) * 3 + 1], 1) << "the paper's dead zone";
    }
}

TEST_F(OckhamMetricsTest, ShadowEdgesShowInSAndNowhereElse) {
    SurfaceWindows windows(8, 8, 4);
    windows.fill(10);
    for (std::uint32_t y = 0; y < 8; ++y)
        for (std::uint32_t x = 0; x < 8; ++x) windows.set_luma(x, y, x < 4 ? 0.15f : 0.75f);
    const Result result = measure(windows);
    for (std::uint32_t y = 0; y < 8; ++y) {
        for (std::uint32_t x = 0; x < 8; ++x) {
            const int k = result.ockham[y * 8 + x];
            if (x == 3 || x == 4)
                EXPECT_GT(k, 1) << x << ", " << y;
            else
                EXPECT_EQ(k, 1) << x << ", " << y;
        }
    }
}

TEST_F(OckhamMetricsTest, SurfacesThatTheNeighboursShowAlikeNeedNoSamples) {
    // A black and a white material, or two greys; every window of the middle column sees both.
    for (const float contrast : {0.0f, 0.8f}) {
        SurfaceWindows windows(3, 3, 4);
        for (std::uint32_t y = 0; y < 3; ++y) {
            for (std::uint32_t x = 0; x < 3; ++x) {
                windows.set_luma(x, y, x == 2 ? 0.1f + contrast : 0.1f);
                for (std::uint32_t i = 0; i < 16; ++i)
                    windows.set(x, y, i, 10, {0, 0, 1}, x == 2 || (x == 1 && i % 4 > 1) ? 1 : 0);
            }
        }
        const Result result = measure(windows);
        for (std::uint32_t y = 0; y < 3; ++y) {
            EXPECT_EQ(result.ockham[y * 3], 1);
            EXPECT_EQ(result.ockham[y * 3 + 1], contrast > 0 ? 2 : 1);
            EXPECT_EQ(result.ockham[y * 3 + 2], 1);
        }
    }
}

TEST_F(OckhamMetricsTest, PricesOfZeroAndInfinityAskForAllAndOne) {
    SurfaceWindows windows = facets(4, {{0, 0, 1}, {0, 0, -1}});
    windows.set(0, 0, 5, 10, {0, 0, 1}, 9);
    EXPECT_EQ(measure(windows, 0.0f).ockham, std::vector<int>(9, 16));
    EXPECT_EQ(
        measure(windows, std::numeric_limits<float>::infinity()).ockham, std::vector<int>(9, 1));
    EXPECT_EQ(measure(SurfaceWindows(3, 3, 4), 0.0f).ockham, std::vector<int>(9, 16)) << "sky";
}

TEST_F(OckhamMetricsTest, GarbageKeepsCountsInRangeAndVarianceFinite) {
    Pcg32 rng(7);
    for (const std::uint32_t m : {2u, 3u, 8u}) {
        SurfaceWindows windows(8, 8, m);
        windows.fill_with_garbage(rng);
        for (glm::vec4& s : windows.first_sample)
            s = glm::vec4(
                rng.below(3) ? rng.uniform(-1e3f, 1e3f) : SurfaceWindows::kOdd[rng.below(6)]);
        const Result result = measure(windows);
        for (const int k : result.ockham) {
            ASSERT_GE(k, 1);
            ASSERT_LE(k, static_cast<int>(m * m));
        }
        for (const glm::vec2 v : result.variance) {
            EXPECT_TRUE(v.x >= 0 && v.x <= 1) << v.x;
            EXPECT_TRUE(v.y >= 0 && v.y <= 4) << v.y;
        }
    }
}

} // namespace
} // namespace ockham::test

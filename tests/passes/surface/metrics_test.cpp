// SPDX-License-Identifier: Apache-2.0
// The paper's metrics on synthetic G-buffers: against a C++ twin, on closed forms, and where they
// are known to fail, the failing values, so that a better metric can be measured against them.
#include "framework/core/image.hpp"
#include "framework/core/rng.hpp"
#include "passes/surface/metrics.hpp"
#include "shaders/shared/frame.h"
#include "shaders/surface/metrics.h"
#include "tests/reference/metrics.hpp"
#include "tests/reference/packing.hpp"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/pass_bench.hpp"

#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

namespace ockham::test {
namespace {

constexpr float kBackgroundDepth = 1937.373f; // sums of it round

/// Windows in code. Stored depth is 1 / view depth; 0 is background.
struct Scenery {
    std::uint32_t width, height, m;
    std::vector<glm::uvec4> surface;
    std::vector<float> stored;
    std::vector<glm::vec4> first_sample;

    Scenery(std::uint32_t w, std::uint32_t h, std::uint32_t window)
        : width(w), height(h), m(window), surface(std::size_t{w} * h * m * m),
          stored(surface.size(), 0.0f), first_sample(std::size_t{w} * h, glm::vec4(0.0f)) {}

    std::uint32_t n() const { return m * m; }
    std::size_t pixels() const { return std::size_t{width} * height; }
    std::size_t place(std::uint32_t x, std::uint32_t y, std::uint32_t i) const {
        return std::size_t{y * m + i / m} * width * m + x * m + i % m;
    }
    void set(std::uint32_t x, std::uint32_t y, std::uint32_t i, float depth, glm::vec3 normal,
        std::uint32_t material = 0) {
        stored[place(x, y, i)] = 1.0f / depth;
        surface[place(x, y, i)] = reference::pack_surface(normal, material);
    }
    /// The view depth that a kernel reconstructs.
    double depth(std::uint32_t x, std::uint32_t y, std::uint32_t i) const {
        const float d = stored[place(x, y, i)];
        return d > 0.0f ? double{1.0f / d} : double{kBackgroundDepth};
    }
    void set_luma(std::size_t pixel, float luma) {
        first_sample[pixel] = glm::vec4(glm::vec3(srgb_decode(luma)), 1.0f);
    }
    double luma(std::int64_t x, std::int64_t y) const {
        const auto cx = std::clamp<std::int64_t>(x, 0, width - 1);
        const auto cy = std::clamp<std::int64_t>(y, 0, height - 1);
        const glm::vec4& s = first_sample[static_cast<std::size_t>(cy * width + cx)];
        return 0.2126 * srgb_encode(s.x) + 0.7152 * srgb_encode(s.y) + 0.0722 * srgb_encode(s.z);
    }
};

class MetricsTest : public GpuTest {
protected:
    struct Result {
        std::vector<int> k, winner;
    };
    static Result measure(const Scenery& scenery, MetricsParams params) {
        PassBench bench(device());
        shader::FrameData frame{};
        frame.near_distance = 1.0f;
        frame.background_depth = kBackgroundDepth;
        frame.m = scenery.m;
        frame.size = {scenery.width, scenery.height};
        const std::uint32_t width = scenery.width * scenery.m, height = scenery.height * scenery.m;
        const Gbuffer gbuffer{.surface = bench.image("gbuffer", VK_FORMAT_R32G32B32A32_UINT, width,
                                  height, scenery.surface),
            .depth = bench.image("depth", VK_FORMAT_R32_SFLOAT, width, height, scenery.stored),
            .extra = {}};
        const ImageHandle s = bench.image("S", VK_FORMAT_R32G32B32A32_SFLOAT, scenery.width,
            scenery.height, scenery.first_sample);
        params.width = scenery.width;
        params.height = scenery.height;
        params.winner = true;
        const Metrics metrics = add_metrics(
            bench.graph, {bench.buffer("frame", std::vector{frame}), gbuffer, s}, params);
        bench.graph.export_resource(metrics.sample_count, "test");
        bench.graph.export_resource(metrics.winner, "test");
        bench.execute();
        return {integers(bench.read(metrics.sample_count)), integers(bench.read(metrics.winner))};
    }
    static std::vector<int> integers(const Image& image) {
        const std::span<const float> plane = image.plane(0);
        std::vector<int> values;
        for (const float v : plane) values.push_back(static_cast<int>(v));
        return values;
    }
    /// One weight at a time.
    static MetricsParams only(float depth, float normal, float shading) {
        MetricsParams params;
        params.depth_weight = depth;
        params.normal_weight = normal;
        params.shading_weight = shading;
        return params;
    }
    /// One pixel whose samples have these normals, repeated in turn, at depth 10.
    static Scenery facets(std::uint32_t m, const std::vector<glm::vec3>& normals) {
        Scenery scenery(1, 1, m);
        for (std::uint32_t i = 0; i < scenery.n(); ++i)
            scenery.set(0, 0, i, 10.0f, normals[i % normals.size()]);
        return scenery;
    }
};

TEST_F(MetricsTest, RandomWindowsAgreeWithTheTwin) {
    MetricsParams params;
    params.depth_weight = 3.0f;
    params.normal_weight = 9.0f;
    params.shading_weight = 12.0f;
    for (const std::uint32_t m : {1u, 2u, 3u, 4u, 8u}) {
        for (const auto& [width, height] : {std::pair{1u, 1u}, {7u, 5u}, {16u, 16u}}) {
            SCOPED_TRACE(testing::Message() << width << "x" << height << ", m = " << m);
            Scenery scenery(width, height, m);
            Pcg32 rng(m * 100 + width);
            for (std::uint32_t y = 0; y < height; ++y) {
                for (std::uint32_t x = 0; x < width; ++x) {
                    // Some windows vary in depth, some in normal, some in both.
                    const float spread = rng.below(2) ? rng.uniform(0.0f, 4.0f) : 0.0f;
                    const float bend = rng.below(2) ? rng.uniform(0.0f, 0.8f) : 0.0f;
                    for (std::uint32_t i = 0; i < scenery.n(); ++i) {
                        const glm::vec3 normal = glm::normalize(
                            glm::vec3(rng.uniform(-bend, bend), rng.uniform(-bend, bend), 1.0f));
                        scenery.set(x, y, i, 5.0f + spread * rng.uniform(), normal, rng.next());
                    }
                    scenery.set_luma(std::size_t{y} * width + x, rng.uniform(0.3f, 0.6f));
                }
            }
            const Result result = measure(scenery, params);
            for (std::uint32_t y = 0; y < height; ++y) {
                for (std::uint32_t x = 0; x < width; ++x) {
                    std::vector<double> depths;
                    std::vector<glm::dvec3> normals;
                    for (std::uint32_t i = 0; i < scenery.n(); ++i) {
                        depths.push_back(scenery.depth(x, y, i));
                        normals.emplace_back(
                            reference::unpack_normal(scenery.surface[scenery.place(x, y, i)].x));
                    }
                    const std::int64_t px = x, py = y;
                    const reference::Window window{depths, normals,
                        {scenery.luma(px - 1, py), scenery.luma(px + 1, py),
                            scenery.luma(px, py - 1), scenery.luma(px, py + 1)}};
                    const auto wanted = reference::wanted_samples(window, params);
                    const double most = *std::max_element(wanted.begin(), wanted.end());
                    // What fp32 may lose: naive variance about 2^-21 d^2; a cone near 0 the square
                    // root of 2^-22; luma the power function's 1e-6.
                    const double slack =
                        std::max({params.depth_weight * 81 * 0x1p-21, wanted[1] * 1e-3, 1e-4});
                    const int n = static_cast<int>(scenery.n());
                    const std::size_t pixel = std::size_t{y} * width + x;
                    const int k = result.k[pixel];
                    EXPECT_GE(k, reference::sample_count(most - slack, n)) << x << "," << y;
                    EXPECT_LE(k, reference::sample_count(most + slack, n)) << x << "," << y;
                    if (k == 1) {
                        EXPECT_EQ(result.winner[pixel], static_cast<int>(WINNER_NONE));
                        continue;
                    }
                    const int winner = result.winner[pixel];
                    ASSERT_GE(winner, static_cast<int>(WINNER_DEPTH));
                    ASSERT_LE(winner, static_cast<int>(WINNER_SHADING));
                    EXPECT_GE(wanted[static_cast<std::size_t>(winner - 1)], most - slack)
                        << "the winner asked for the most";
                }
            }
        }
    }
}

/// A plane tilted by `degrees` around the vertical axis, at `distance` where the pixel looks, in a
/// window of `extent` = tangent of the pixel's angle.
Scenery slanted_plane(double distance, double degrees, double extent) {
    Scenery scenery(1, 1, 4);
    const double slope = std::tan(degrees * std::numbers::pi / 180);
    for (std::uint32_t i = 0; i < 16; ++i) {
        const double t = ((i % 4 + 0.5) / 4 - 0.5) * extent;
        scenery.set(0, 0, i, static_cast<float>(distance / (1 - t * slope)),
            glm::normalize(glm::vec3(std::sin(1.4), 0, std::cos(1.4))));
    }
    return scenery;
}

TEST_F(MetricsTest, SlantedPlaneGrowsWithTheSquareOfTheScale) {
    const double extent = 2 * std::tan(32.5 * std::numbers::pi / 180) / 768; // 65 degrees, 768 rows
    const auto variance = [&](double distance, double degrees) {
        const Scenery scenery = slanted_plane(distance, degrees, extent);
        std::vector<double> depths;
        for (std::uint32_t i = 0; i < 16; ++i) depths.push_back(scenery.depth(0, 0, i));
        return reference::two_pass_variance(depths);
    };
    // One flat plane, no edge anywhere: the variance is an artefact of the slope.
    EXPECT_NEAR(variance(50, 85), 7.0e-2, 0.01 * 7.0e-2);
    EXPECT_NEAR(variance(50, 89), 1.77, 0.01 * 1.77);
    EXPECT_NEAR(variance(5, 85), 7.0e-4, 0.01 * 7.0e-4);
    const MetricsParams params = only(100.0f, 0.0f, 0.0f);
    EXPECT_EQ(measure(slanted_plane(50, 85, extent), params).k[0], 8) << "ceil(7.02)";
    EXPECT_EQ(measure(slanted_plane(50, 89, extent), params).k[0], 16);
    // The same picture in other units: the paper's metric is not scale-invariant.
    EXPECT_EQ(measure(slanted_plane(0.5, 85, extent), params).k[0], 1);
    EXPECT_EQ(measure(slanted_plane(5000, 85, extent), params).k[0], 16);
}

TEST_F(MetricsTest, CoplanarMaterialsGoUnseenByGeometry) {
    Scenery scenery(4, 4, 4);
    for (std::uint32_t y = 0; y < 4; ++y)
        for (std::uint32_t x = 0; x < 4; ++x)
            for (std::uint32_t i = 0; i < 16; ++i)
                scenery.set(x, y, i, 8.0f, {0, 0, 1}, (i + i / 4) % 2);
    const Result result = measure(scenery, only(1e6f, 1e6f, 0.0f));
    EXPECT_EQ(result.k, std::vector<int>(16, 1)) << "n is needed; the paper's metric says 1";
}

TEST_F(MetricsTest, CreasesAskForTheConeOfTheirNormals) {
    const auto crease = [](double degrees) {
        const double half = 0.5 * degrees * std::numbers::pi / 180;
        return std::vector<glm::vec3>{
            {std::sin(half), 0, std::cos(half)}, {-std::sin(half), 0, std::cos(half)}};
    };
    EXPECT_EQ(measure(facets(8, crease(90)), only(0, 100.0f, 0)).k[0], 55) << "ceil(0.5412 c)";
    EXPECT_EQ(measure(facets(8, crease(10)), only(0, 1000.0f, 0)).k[0], 62) << "ceil(0.0617 c)";
    EXPECT_EQ(measure(facets(8, {{0, 0, 1}}), only(0, 1000.0f, 0)).k[0], 1) << "flat";
}

TEST_F(MetricsTest, FoldCancelsItsNormalsAndGoesUnseen) {
    EXPECT_EQ(measure(facets(4, {{0, 0, 1}, {0, 0, -1}}), only(0, 1000.0f, 0)).k[0], 1)
        << "a fold needs n samples; the paper's mean normal vanishes";
}

TEST_F(MetricsTest, NormalsAround120DegreesStayInRange) {
    const float s = std::sqrt(3.0f) / 2;
    const int k =
        measure(facets(3, {{1, 0, 0}, {-0.5f, s, 0}, {-0.5f, -s, 0}}), MetricsParams{}).k[0];
    EXPECT_GE(k, 1);
    EXPECT_LE(k, 9);
}

TEST_F(MetricsTest, GarbageInTheGbufferKeepsCountsInRange) {
    Pcg32 rng(7);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float odd[] = {nan, std::numeric_limits<float>::infinity(), 1e-40f, -1.0f, 0.0f, 3e38f};
    for (const std::uint32_t m : {2u, 3u, 8u}) {
        Scenery scenery(8, 8, m);
        for (glm::uvec4& words : scenery.surface)
            words = {rng.next(), rng.next(), rng.next(), rng.next()};
        for (float& depth : scenery.stored)
            depth = rng.below(2) ? odd[rng.below(6)] : std::bit_cast<float>(rng.next());
        for (glm::vec4& s : scenery.first_sample)
            s = glm::vec4(rng.below(3) ? rng.uniform(-1e3f, 1e3f) : odd[rng.below(6)]);
        for (const int k : measure(scenery, MetricsParams{}).k) {
            ASSERT_GE(k, 1);
            ASSERT_LE(k, static_cast<int>(m * m));
        }
    }
}

TEST_F(MetricsTest, SkyTakesOneSampleAndItsEdgeAll) {
    for (const std::uint32_t m : {2u, 3u, 4u}) {
        Scenery scenery(8, 8, m);
        EXPECT_EQ(measure(scenery, MetricsParams{}).k, std::vector<int>(64, 1)) << "m = " << m;
        scenery.set(3, 4, 1, 20.0f, {0, 0, 1});
        std::vector<int> expected(64, 1);
        expected[4 * 8 + 3] = static_cast<int>(m * m);
        EXPECT_EQ(measure(scenery, MetricsParams{}).k, expected) << "m = " << m;
    }
}

TEST_F(MetricsTest, ConstantDepthLeavesRoundingNoiseThatCostsSamples) {
    // Parallel to the picture at 1 to 1e6: an exact variance is 0, that of fp32 sums is not.
    std::vector<float> distances;
    for (float z = 1.0f; z <= 1.0001e6f; z *= 1.5848932f) distances.push_back(z);
    float noise = 0;
    std::vector<int> k;
    Scenery scenery(static_cast<std::uint32_t>(distances.size()), 1, 3);
    for (std::uint32_t x = 0; x < scenery.width; ++x) {
        std::vector<float> fp32;
        std::vector<double> exact;
        for (std::uint32_t i = 0; i < 9; ++i) {
            scenery.set(x, 0, i, distances[x], {0, 0, 1});
            exact.push_back(scenery.depth(x, 0, i));
            fp32.push_back(static_cast<float>(exact.back()));
        }
        EXPECT_EQ(reference::two_pass_variance(exact), 0.0);
        noise = std::max(noise, std::abs(reference::naive_variance(fp32)));
    }
    EXPECT_GT(noise, 1.0f) << "square units, out of nothing";
    const Result result = measure(scenery, MetricsParams{});
    for (std::size_t x = 0; distances[x] < 50.0f; ++x) EXPECT_EQ(result.k[x], 1) << distances[x];
    EXPECT_EQ(*std::max_element(result.k.begin(), result.k.end()), 9)
        << "the paper's formula spends all samples on a plane without an edge";
}

TEST_F(MetricsTest, ShadingHasADeadZoneAndThenAJump) {
    const MetricsParams params = only(0, 0, 40.0f);
    for (const float base : {0.0f, 0.1f, 0.3f, 0.6f}) {
        constexpr std::uint32_t kSteps = 41;
        // Rows of two pixels: the left sees `base` and `base + r` to its sides.
        Scenery scenery(3, 3 * kSteps, 8);
        for (std::uint32_t s = 0; s < kSteps; ++s) {
            const float r = 0.2f * static_cast<float>(s) / (kSteps - 1);
            for (std::uint32_t row = 0; row < 3; ++row) {
                for (std::uint32_t x = 0; x < 3; ++x)
                    scenery.set_luma((3 * s + row) * 3 + x, x == 2 ? base + r : base);
            }
        }
        const Result result = measure(scenery, params);
        for (std::uint32_t s = 0; s < kSteps; ++s) {
            const std::int64_t row = 3 * s + 1;
            const double low = scenery.luma(0, row), high = scenery.luma(2, row), r = high - low;
            const double threshold = std::max<double>(params.range_min, high * params.range_edge);
            const int k = result.k[static_cast<std::size_t>(row) * 3 + 1];
            if (r < threshold - 1e-5) {
                EXPECT_EQ(k, 1) << "base " << base << ", step " << r;
            } else if (r > threshold + 1e-5) {
                EXPECT_GE(k, reference::sample_count(40 * r - 1e-3, 64)) << base << ", " << r;
                EXPECT_LE(k, reference::sample_count(40 * r + 1e-3, 64)) << base << ", " << r;
                EXPECT_EQ(result.winner[static_cast<std::size_t>(row) * 3 + 1],
                    static_cast<int>(k > 1 ? WINNER_SHADING : WINNER_NONE));
            }
        }
    }
}

TEST_F(MetricsTest, ShadingLooksAtDirectNeighboursOnlyAndClampsAtTheBorder) {
    Scenery scenery(7, 5, 2);
    for (std::size_t i = 0; i < scenery.pixels(); ++i) scenery.set_luma(i, 0.2f);
    scenery.set_luma(0, 0.9f);         // corner: its own clamped neighbour
    scenery.set_luma(2 * 7 + 3, 0.9f); // middle
    scenery.set_luma(4 * 7 + 6, 0.9f); // corner
    std::vector<int> expected(35, 1);
    for (const std::size_t i : {0u, 1u, 7u, 10u, 16u, 18u, 24u, 27u, 33u, 34u}) expected[i] = 4;
    EXPECT_EQ(measure(scenery, only(0, 0, 40.0f)).k, expected);
}

} // namespace
} // namespace ockham::test

// SPDX-License-Identifier: Apache-2.0
// Labels of samples by surface, on synthetic G-buffers: against a C++ twin, and where surfaces
// begin and end.
#include "framework/core/rng.hpp"
#include "passes/surface/clusters.hpp"
#include "tests/reference/clusters.hpp"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/surface_windows.hpp"

#include <algorithm>
#include <bit>
#include <limits>
#include <set>

namespace ockham::test {
namespace {

using Labels = std::vector<std::uint32_t>;

class ClustersTest : public GpuTest {
protected:
    struct Result {
        std::vector<Labels> labels; ///< per pixel, by rank
        std::vector<glm::vec4> spread;
        std::vector<glm::uvec2> first;
    };
    static Result cluster(const SurfaceWindows& windows) {
        PassBench bench(device());
        const Clusters clusters =
            add_clusters(bench.graph, bench.buffer("frame", std::vector{windows.frame()}),
                windows.gbuffer(bench), {windows.width, windows.height, windows.m}, "test");
        const ImageHandle labels = bench.keep(clusters.labels);
        const ImageHandle spread = bench.keep(clusters.normal_spread);
        const ImageHandle first = bench.keep(clusters.first_surface);
        bench.execute();
        Result result;
        const auto words = bench.texels<std::uint32_t>(labels);
        const std::size_t per_pixel = windows.n() > 16 ? 4 : 1;
        for (std::size_t p = 0; p < windows.pixels(); ++p) {
            Labels of_pixel;
            for (std::uint32_t r = 0; r < windows.n(); ++r)
                of_pixel.push_back(words[p * per_pixel + r / 16] >> (2 * (r % 16)) & 3u);
            result.labels.push_back(of_pixel);
            for (std::uint32_t r = windows.n(); r < 16 * per_pixel; ++r)
                EXPECT_EQ(words[p * per_pixel + r / 16] >> (2 * (r % 16)) & 3u, 0u) << "unused";
        }
        for (const glm::u8vec4 texel : bench.texels<glm::u8vec4>(spread))
            result.spread.push_back(glm::vec4(texel) / 255.0f);
        result.first = bench.texels<glm::uvec2>(first);
        return result;
    }
    static Labels single(const SurfaceWindows& windows) { return Labels(windows.n(), 0u); }
};

/// A plane through the window of pixel (x, y), seen at any angle: stored depth `at` in its corner.
void set_plane(SurfaceWindows& windows, std::uint32_t x, std::uint32_t y, std::uint32_t i, float at,
    glm::vec2 slope, std::uint32_t material) {
    const glm::vec2 offset(static_cast<float>(i % windows.m), static_cast<float>(i / windows.m));
    windows.set(x, y, i, 1.0f / (at + glm::dot(slope, offset)), {0, 0, 1}, material, slope);
}

TEST_F(ClustersTest, RandomWindowsAgreeWithTheTwin) {
    for (const std::uint32_t m : {1u, 2u, 3u, 4u, 5u, 8u}) {
        SCOPED_TRACE(testing::Message() << "m = " << m);
        SurfaceWindows windows(m == 8 ? 7 : 16, 9, m);
        Pcg32 rng(m);
        for (std::uint32_t i = windows.n(); i-- > 1;)
            std::swap(windows.order[i], windows.order[rng.below(i + 1)]);
        for (std::uint32_t y = 0; y < windows.height; ++y) {
            for (std::uint32_t x = 0; x < windows.width; ++x) {
                // Up to six surfaces, one of them the background, in random places.
                const std::uint32_t count = 1 + rng.below(6);
                std::vector<glm::vec3> planes;
                for (std::uint32_t s = 0; s < count; ++s) {
                    planes.emplace_back(rng.uniform(0.05f, 0.2f), rng.uniform(-2e-3f, 2e-3f),
                        rng.uniform(-2e-3f, 2e-3f));
                }
                for (std::uint32_t i = 0; i < windows.n(); ++i) {
                    const std::uint32_t s = rng.below(count);
                    if (s == 5) continue;
                    set_plane(windows, x, y, i, planes[s].x, {planes[s].y, planes[s].z}, s / 2);
                    const glm::vec3 normal(rng.uniform(-1, 1), rng.uniform(-1, 1), 1.5f);
                    windows.surface[windows.place(x, y, i)] =
                        reference::pack_surface(glm::normalize(normal), s / 2);
                }
            }
        }
        const Result result = cluster(windows);
        std::set<std::uint32_t> seen;
        for (std::uint32_t y = 0; y < windows.height; ++y) {
            for (std::uint32_t x = 0; x < windows.width; ++x) {
                std::vector<reference::WindowSample> samples;
                for (const std::uint32_t i : windows.order) {
                    const std::size_t at = windows.place(x, y, i);
                    const double depth = windows.stored[at];
                    samples.push_back({depth > 0, depth,
                        glm::dvec2(glm::unpackHalf2x16(windows.slopes[at])) * depth,
                        reference::unpack_material(windows.surface[at]), glm::dvec2(i % m, i / m)});
                }
                const std::size_t p = std::size_t{y} * windows.width + x;
                const Labels expected = reference::cluster_labels(samples, 0.01);
                ASSERT_EQ(result.labels[p], expected) << "pixel " << x << ", " << y;
                for (std::uint32_t label = 0; label < 4; ++label) {
                    std::vector<glm::dvec3> normals;
                    for (std::uint32_t r = 0; r < windows.n(); ++r) {
                        const std::size_t at = windows.place(x, y, windows.order[r]);
                        if (expected[r] != label) continue;
                        seen.insert(label);
                        normals.emplace_back(windows.stored[at] > 0
                                                 ? reference::unpack_normal(windows.surface[at].x)
                                                 : glm::vec3(0, 0, 1));
                    }
                    EXPECT_NEAR(result.spread[p][static_cast<int>(label)],
                        reference::normal_spread(normals), 0.004);
                }
                const std::size_t first = windows.place(x, y, windows.order[0]);
                EXPECT_EQ(result.first[p].x, std::bit_cast<std::uint32_t>(windows.stored[first]));
                if (samples[0].hit) {
                    EXPECT_EQ(result.first[p].y, samples[0].material);
                }
            }
        }
        EXPECT_EQ(seen.size(), std::min(4u, m * m)) << "all labels were tried";
    }
}

TEST_F(ClustersTest, PlaneAtAnyAngleAndScaleIsOneSurface) {
    // Up to 89.9 degrees: stored depth falls by tan(angle) pixels' share of itself from one pixel
    // to the next, until it meets the horizon.
    for (const float scale : {1.0f, 100.0f}) {
        SurfaceWindows windows(16, 1, 8);
        for (std::uint32_t x = 0; x < 16; ++x) {
            const float angle = glm::radians(std::min(6.0f * static_cast<float>(x), 89.9f));
            const float at = 0.1f / scale, per_sample = 0.01f / 8 * std::tan(angle) * at;
            const float steep = std::min(per_sample, at / 16);
            for (std::uint32_t i = 0; i < 64; ++i)
                set_plane(windows, x, 0, i, at, {steep, -0.5f * steep}, 7);
        }
        EXPECT_EQ(cluster(windows).labels, std::vector<Labels>(16, single(windows)));
    }
}

TEST_F(ClustersTest, StepsOfDepthSplitWhereTheyExceedAThirdOfAPixel) {
    // At m = 2 a plane fitted to the window would follow every step along an axis.
    for (const float scale : {1.0f, 100.0f}) {
        for (const std::uint32_t m : {2u, 4u}) {
            SurfaceWindows windows(2, 1, m);
            const float depth = 10.0f * scale, pixel = 0.01f * depth;
            for (std::uint32_t i = 0; i < windows.n(); ++i) {
                const bool behind = i % m >= m / 2;
                windows.set(0, 0, i, depth + (behind ? 0.25f * pixel : 0.0f));
                windows.set(1, 0, i, depth + (behind ? 0.35f * pixel : 0.0f));
            }
            const std::vector<Labels> labels = cluster(windows).labels;
            EXPECT_EQ(labels[0], single(windows));
            for (std::uint32_t i = 0; i < windows.n(); ++i)
                EXPECT_EQ(labels[1][i], i % m >= m / 2 ? 1u : 0u);
        }
    }
}

TEST_F(ClustersTest, MaterialsInOnePlaneAreSurfaces) {
    SurfaceWindows windows(1, 1, 4);
    for (std::uint32_t i = 0; i < 16; ++i) windows.set(0, 0, i, 8, {0, 0, 1}, (i + i / 4) % 2);
    const Labels labels = cluster(windows).labels[0];
    for (std::uint32_t i = 0; i < 16; ++i) EXPECT_EQ(labels[i], (i + i / 4) % 2);
}

TEST_F(ClustersTest, BackgroundIsOneSurfaceApart) {
    SurfaceWindows windows(2, 1, 3);
    windows.set(1, 0, 4, 20);
    const Result result = cluster(windows);
    EXPECT_EQ(result.labels[0], single(windows));
    EXPECT_EQ(result.labels[1], (Labels{0, 0, 0, 0, 1, 0, 0, 0, 0}));
    EXPECT_EQ(result.spread, std::vector<glm::vec4>(2, glm::vec4(0.0f)));
    EXPECT_EQ(result.first[0].x, 0u);
}

TEST_F(ClustersTest, NormalsThatCancelSpreadAsFarAsCanBe) {
    SurfaceWindows windows(3, 1, 3);
    const float s = std::sqrt(3.0f) / 2;
    const glm::vec3 three[] = {{1, 0, 0}, {-0.5f, s, 0}, {-0.5f, -s, 0}};
    for (std::uint32_t i = 0; i < 9; ++i) {
        windows.set(0, 0, i, 5, {0, 0, i % 2 ? 1 : -1});
        windows.set(1, 0, i, 5, three[i % 3]);
        windows.set(2, 0, i, 5, {0, 0.6f, 0.8f});
    }
    const Result result = cluster(windows);
    EXPECT_EQ(result.spread[0].x, 1.0f) << "a fold by 180 degrees";
    EXPECT_EQ(result.spread[1].x, 1.0f) << "three normals around";
    EXPECT_NEAR(result.spread[2].x, 0.0f, 0.01f);
}

TEST_F(ClustersTest, GarbageInTheGbufferKeepsLabelsInOrder) {
    Pcg32 rng(7);
    for (const std::uint32_t m : {2u, 8u}) {
        SurfaceWindows windows(8, 8, m);
        windows.fill_with_garbage(rng);
        for (const Labels& labels : cluster(windows).labels) {
            EXPECT_EQ(labels[0], 0u);
            std::uint32_t next = 0;
            for (const std::uint32_t label : labels) {
                EXPECT_LE(label, next) << "labels are numbered as they first occur";
                next = std::max(next, label + 1);
            }
        }
    }
}

} // namespace
} // namespace ockham::test

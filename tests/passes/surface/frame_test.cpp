// SPDX-License-Identifier: Apache-2.0
// Sample orders as printed in the paper, and the camera's numbers that every kernel uses.
#include "framework/core/rng.hpp"
#include "passes/surface/frame.hpp"
#include "tests/support/gpu_fixture.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace ockham::test {
namespace {

using Order = std::vector<std::uint32_t>;

/// The paper prints ranks: the sample at row-major place p is taken ranks[p]-th.
Order ranks_of(const Order& order) {
    Order ranks(order.size());
    for (std::uint32_t i = 0; i < order.size(); ++i) ranks[order[i]] = i;
    return ranks;
}

TEST(PaperOrder, MatchesThePrintedMatrices) {
    EXPECT_EQ(paper_order(1), Order{0});
    EXPECT_EQ(ranks_of(paper_order(2)), (Order{0, 2, 3, 1}));
    EXPECT_EQ(ranks_of(paper_order(3)), (Order{2, 6, 3, 5, 0, 8, 1, 7, 4}));
    EXPECT_EQ(
        ranks_of(paper_order(4)), (Order{1, 8, 2, 10, 12, 4, 14, 6, 3, 11, 0, 9, 15, 7, 13, 5}));
    EXPECT_EQ(paper_order(4)[0], 2u * 4 + 2) << "the first sample stands in row 2, column 2";
}

TEST(PaperOrder, IsAPermutation) {
    for (const int m : {1, 2, 3, 4, 8}) {
        Order sorted = paper_order(m);
        std::sort(sorted.begin(), sorted.end());
        Order all(static_cast<std::size_t>(m * m));
        std::iota(all.begin(), all.end(), 0u);
        EXPECT_EQ(sorted, all) << "m = " << m;
    }
}

TEST(PaperOrder, EightIsBayersRecursion) {
    // Every aligned prefix of 4^j samples has one in each of the 4^j equal squares.
    const Order order = paper_order(8);
    for (std::uint32_t cells = 2; cells <= 8; cells *= 2) {
        std::vector<int> hits(cells * cells, 0);
        for (std::uint32_t i = 0; i < cells * cells; ++i) {
            const std::uint32_t x = order[i] % 8, y = order[i] / 8;
            ++hits[y * cells / 8 * cells + x * cells / 8];
        }
        EXPECT_EQ(hits, std::vector<int>(cells * cells, 1)) << cells << " x " << cells;
    }
    // The 2 x 2 matrix of the paper, one level down: neighbours in rank are diagonal.
    for (std::uint32_t i = 0; i < 64; i += 2) {
        EXPECT_EQ((order[i] % 8 + 4) % 8, order[i + 1] % 8);
        EXPECT_EQ((order[i] / 8 + 4) % 8, order[i + 1] / 8);
    }
}

TEST(PaperOrder, OtherWindowsAreRefused) {
    for (const int m : {0, 5, 6, 7, 9, -1}) {
        const std::string text = error_of([&] { paper_order(m); });
        EXPECT_NE(text.find("m = " + std::to_string(m)), std::string::npos) << text;
        EXPECT_NE(text.find("1, 2, 3, 4 or 8"), std::string::npos) << text;
    }
}

Bounds unit_bounds() {
    Bounds bounds;
    bounds.add({-1, -1, -1});
    bounds.add({1, 1, 1});
    return bounds;
}

TEST(Frame, PerspectiveDepthIsNearOverDepth) {
    const Camera camera = look_at({3, 1, 5}, {0, 0.5f, 0}, 50);
    const shader::FrameData frame =
        make_frame({}, unit_bounds(), camera, 640, 480, 2, paper_order(2), 1);
    Pcg32 rng(1);
    for (int i = 0; i < 100; ++i) {
        const glm::vec3 p(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
        const glm::vec4 clip = frame.view_projection * glm::vec4(p, 1.0f);
        const float depth = glm::dot(p - camera.position, camera.forward);
        EXPECT_NEAR(clip.w, depth, 1e-5f * depth);
        EXPECT_NEAR(clip.z / clip.w, frame.near_distance / depth, 1e-6f);
        // What sample_world() does with it leads back.
        const glm::vec3 back =
            camera.position +
            depth * (camera.forward + clip.x / clip.w * frame.right - clip.y / clip.w * frame.up);
        EXPECT_LT(glm::length(back - p), 1e-4f);
    }
    EXPECT_GT(frame.background_depth, frame.far_distance);
}

TEST(Frame, OrthographicDepthIsLinear) {
    Camera camera = look_at({0, 0, 5}, {0, 0, 0}, 50);
    camera.orthographic_height = 4;
    const shader::FrameData frame = make_frame({}, unit_bounds(), camera, 8, 4, 1, {0}, 1);
    EXPECT_EQ(frame.orthographic, 1u);
    for (const float z : {-1.0f, 0.0f, 1.0f}) {
        const glm::vec4 clip = frame.view_projection * glm::vec4(2, -1, z, 1);
        EXPECT_FLOAT_EQ(clip.w, 1.0f);
        EXPECT_NEAR(clip.x, 0.5f, 1e-6f) << "8 units wide";
        EXPECT_NEAR(clip.y, 0.5f, 1e-6f) << "y points down";
        EXPECT_NEAR(frame.far_distance * (1 - clip.z), 5 - z, 1e-5f);
    }
}

TEST(Frame, SunMatrixHoldsTheWholeScene) {
    Pcg32 rng(3);
    for (int i = 0; i < 50; ++i) {
        Scene scene;
        Light sun;
        sun.type = LightType::directional;
        sun.casts_shadow = true;
        sun.direction = i == 0 ? glm::vec3(0, -1, 0)
                               : glm::normalize(glm::vec3(
                                     rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1)));
        scene.lights = {sun};
        const shader::FrameData frame =
            make_frame(scene, unit_bounds(), look_at({0, 0, 5}, {0, 0, 0}, 50), 8, 8, 1, {0}, 1024);
        for (int corner = 0; corner < 8; ++corner) {
            const glm::vec3 p(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
            const glm::vec4 q = frame.sun_projection * glm::vec4(p, 1);
            EXPECT_LE(std::abs(q.x), 1.0f);
            EXPECT_LE(std::abs(q.y), 1.0f);
            EXPECT_GE(q.z, 0.0f);
            EXPECT_LE(q.z, 1.0f);
            const glm::vec4 nearer = frame.sun_projection * glm::vec4(p - 0.1f * sun.direction, 1);
            EXPECT_GT(nearer.z, q.z) << "1 is nearest to the sun";
        }
        EXPECT_GT(frame.sun_texel, 2.0f / 1024);
        EXPECT_LT(frame.sun_texel, 4.0f / 1024);
    }
}

TEST(Frame, CountsLightsByType) {
    Scene scene;
    scene.lights.resize(6);
    scene.lights[0].type = LightType::spot;
    scene.lights[3].type = LightType::directional;
    const shader::FrameData frame =
        make_frame(scene, {}, look_at({0, 0, 5}, {0, 0, 0}, 50), 1, 1, 1, {0}, 1);
    EXPECT_EQ(frame.directional_count, 1u);
    EXPECT_EQ(frame.point_count, 4u);
    EXPECT_EQ(frame.spot_count, 1u);
}

} // namespace
} // namespace ockham::test

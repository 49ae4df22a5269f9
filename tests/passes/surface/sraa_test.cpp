// SPDX-License-Identifier: Apache-2.0
// Reconstruction from one shaded sample per pixel: exact where every surface of a window has been
// shaded nearby, S where none has.
#include "passes/surface/sraa.hpp"
#include "shaders/shared/frame.h"
#include "tests/reference/packing.hpp"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/pass_bench.hpp"

#include <cmath>

namespace ockham::test {
namespace {

constexpr std::uint32_t kWindow = 4;

/// A 7 x 5 picture of flat surfaces that face an orthographic camera; one pixel is one unit.
class SraaTest : public GpuTest {
protected:
    struct Surface {
        float depth; ///< 0: background
        glm::vec3 color;
        glm::vec3 normal = {0, 0, 1};
    };
    static constexpr std::uint32_t kWidth = 7, kHeight = 5;

    /// `at`: the surface that sample (x, y) of the supersampled picture sees.
    template <class F>
    static Image reconstruct(F at) {
        const std::uint32_t width = kWidth * kWindow, height = kHeight * kWindow;
        std::vector<glm::uvec4> surface;
        std::vector<float> depth;
        for (std::uint32_t y = 0; y < height; ++y) {
            for (std::uint32_t x = 0; x < width; ++x) {
                const Surface s = at(x, y);
                surface.push_back(reference::pack_surface(s.normal, 0));
                depth.push_back(s.depth > 0 ? 1.0f - s.depth / 100.0f : 0.0f);
            }
        }
        std::vector<glm::vec4> first;
        for (std::uint32_t i = 0; i < kWidth * kHeight; ++i) {
            const Surface s = at(i % kWidth * kWindow + 2, i / kWidth * kWindow + 2);
            first.emplace_back(s.color, s.depth > 0 ? 1.0f : 0.0f);
        }
        shader::FrameData frame{};
        frame.orthographic = 1;
        frame.far_distance = 100.0f;
        frame.right = {0.5f * kWidth, 0, 0};
        frame.up = {0, 0.5f * kHeight, 0};
        frame.forward = {0, 0, -1};
        frame.m = kWindow;
        frame.size = frame.picture = {kWidth, kHeight};
        frame.order[0] = 2 * kWindow + 2;
        PassBench bench(device());
        const ImageHandle out = add_sraa(bench.graph,
            {bench.buffer("frame", std::vector{frame}),
                {.surface =
                        bench.image("gbuffer", VK_FORMAT_R32G32B32A32_UINT, width, height, surface),
                    .depth = bench.image("depth", VK_FORMAT_R32_SFLOAT, width, height, depth),
                    .extra = {}},
                bench.image("S", VK_FORMAT_R32G32B32A32_SFLOAT, kWidth, kHeight, first)});
        bench.graph.export_resource(out, "test");
        bench.execute();
        return bench.read(out);
    }
    template <class F>
    static glm::vec4 mean(F at, std::uint32_t x, std::uint32_t y) {
        glm::vec4 sum(0.0f);
        for (std::uint32_t i = 0; i < kWindow * kWindow; ++i) {
            const Surface s = at(x * kWindow + i % kWindow, y * kWindow + i / kWindow);
            sum += glm::vec4(s.color, s.depth > 0 ? 1.0f : 0.0f);
        }
        return sum / static_cast<float>(kWindow * kWindow);
    }
    template <class F>
    static void expect_all_exact(F at) {
        const Image picture = reconstruct(at);
        for (std::uint32_t y = 0; y < kHeight; ++y) {
            for (std::uint32_t x = 0; x < kWidth; ++x) {
                for (int c = 0; c < 4; ++c) {
                    EXPECT_NEAR(picture.at(int(x), int(y), c), mean(at, x, y)[c], 1e-5f)
                        << x << ", " << y << ", channel " << c;
                }
            }
        }
    }
};

TEST_F(SraaTest, EdgesBetweenShadedSurfacesAreExact) {
    // Told apart by depth, by the sky behind, by the normal.
    for (const Surface other :
        {Surface{60, {0, 4, 0}}, Surface{0, {0, 0, 1}}, Surface{50, {0, 4, 0}, {1, 0, 0}}}) {
        expect_all_exact([=](std::uint32_t x, std::uint32_t y) {
            return 2 * x + 3 * y < 58 ? Surface{50, {1, 0.5f, 0.25f}} : other;
        });
    }
}

TEST_F(SraaTest, CoplanarColoursRunIntoEachOther) {
    // Same depth, same normal: a decal's edge is S, blurred. The paper's method knows no materials.
    const auto at = [](std::uint32_t x, std::uint32_t) {
        return Surface{50, x < 14 ? glm::vec3(1.0f) : glm::vec3(0.0f)};
    };
    const Image picture = reconstruct(at);
    EXPECT_EQ(mean(at, 3, 2).x, 0.5f);
    EXPECT_LT(picture.at(3, 2, 0), 0.4f) << "the pixel's own first sample is dark";
    EXPECT_LT(picture.at(2, 2, 0), 0.999f) << "and darkness runs beyond the edge";
}

TEST_F(SraaTest, SurfacesThatNobodyShadedAreMissing) {
    // A speck off the first samples, in front of everything.
    const auto at = [](std::uint32_t x, std::uint32_t y) {
        return x == 12 && y == 8 ? Surface{10, {100, 100, 100}} : Surface{50, {0.25f, 0.5f, 1}};
    };
    const Image picture = reconstruct(at);
    EXPECT_NEAR(picture.at(3, 2, 0), 0.25f, 1e-5f);
    EXPECT_GT(mean(at, 3, 2).x, 6.0f);
}

} // namespace
} // namespace ockham::test

// SPDX-License-Identifier: Apache-2.0
// FXAA on pictures whose smoothed edges are known: gentle staircases become coverage ramps, flat
// parts keep their bits, and no direction is preferred.
#include "framework/core/image.hpp"
#include "passes/post/display.hpp"
#include "passes/post/fxaa.hpp"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/pass_bench.hpp"

#include <glm/glm.hpp>

#include <cmath>
#include <functional>

namespace ockham::test {
namespace {

constexpr float kHalf = 2e-3f; // rounding of the displayed picture

class FxaaTest : public GpuTest {
protected:
    /// `shown`: display-encoded grey of a pixel. Returns display-encoded greys.
    static Image filter(std::uint32_t width, std::uint32_t height,
        const std::function<float(int, int)>& shown, const FxaaParams& params = {}) {
        std::vector<glm::vec4> radiance;
        for (std::uint32_t i = 0; i < width * height; ++i) {
            const float grey =
                srgb_decode(shown(static_cast<int>(i % width), static_cast<int>(i / width)));
            radiance.emplace_back(grey, grey, grey, 0.5f);
        }
        PassBench bench(device());
        const ImageHandle in =
            bench.image("radiance", VK_FORMAT_R32G32B32A32_SFLOAT, width, height, radiance);
        const ImageHandle out = add_fxaa(bench.graph, in, add_display(bench.graph, in), params);
        bench.graph.export_resource(out, "test");
        bench.execute();
        Image picture = bench.read(out);
        for (const float alpha : picture.plane("A")) EXPECT_EQ(alpha, 0.5f);
        for (float& v : picture.plane("R")) v = srgb_encode(v);
        return picture;
    }
    static FxaaParams without_blur() {
        FxaaParams params;
        params.subpixel = 0.0f;
        return params;
    }
};

TEST_F(FxaaTest, FlatAndFaintPicturesKeepTheirBits) {
    for (const auto& [width, height] : {std::pair{1u, 1u}, {7u, 5u}, {64u, 64u}}) {
        std::vector<glm::vec4> radiance;
        for (std::uint32_t i = 0; i < width * height; ++i) {
            // Luma ranges just below the larger threshold: 1/8 of the brightest.
            const float grey = srgb_decode(i % 2 ? 0.8f : 0.71f);
            radiance.emplace_back(grey, grey, grey, 1.0f);
        }
        PassBench bench(device());
        const ImageHandle in =
            bench.image("radiance", VK_FORMAT_R32G32B32A32_SFLOAT, width, height, radiance);
        const ImageHandle out = add_fxaa(bench.graph, in, add_display(bench.graph, in));
        bench.graph.export_resource(out, "test");
        bench.execute();
        const std::vector<float> picture = interleaved(bench.read(out));
        for (std::size_t i = 0; i < picture.size(); ++i)
            ASSERT_EQ(picture[i], radiance[i / 4][static_cast<int>(i % 4)]);
    }
}

TEST_F(FxaaTest, StaircasesBecomeCoverageRamps) {
    // An edge that descends one row every `run` pixels. FXAA counts up to the centre of the first
    // pixel past each end, run + 1 in all, so its ramps are a little flatter than coverage. The
    // nearer end is at most 4 pixels away, where each step of the search is one pixel.
    for (const int run : {2, 3, 4, 5, 8}) {
        for (const bool transposed : {false, true}) {
            SCOPED_TRACE(testing::Message() << "run " << run << (transposed ? ", transposed" : ""));
            const int size = 48;
            const auto height_at = [&](int x) { return 8 + x / run; }; // first bright row
            const Image picture = filter(
                size, size,
                [&](int x, int y) {
                    if (transposed) std::swap(x, y);
                    return y >= height_at(x) ? 0.75f : 0.25f;
                },
                without_blur());
            for (int x = 3 * run; x < size - 3 * run; ++x) {
                const int row = height_at(x), d = x % run;
                const float span = static_cast<float>(run + 1);
                const float lost = std::max(0.0f, 0.5f - static_cast<float>(run - d) / span);
                const float gained = std::max(0.0f, 0.5f - static_cast<float>(d + 1) / span);
                const float bright = transposed ? picture.at(row, x, 0) : picture.at(x, row, 0);
                const float dark =
                    transposed ? picture.at(row - 1, x, 0) : picture.at(x, row - 1, 0);
                EXPECT_NEAR(bright, 0.75f - 0.5f * lost, kHalf) << "column " << x;
                EXPECT_NEAR(dark, 0.25f + 0.5f * gained, kHalf) << "column " << x;
            }
        }
    }
}

TEST_F(FxaaTest, MirroredAndTurnedPicturesAreFilteredAlike) {
    const int size = 32;
    const auto scene = [](int x, int y) { // a slanted bar and a disc; a gradient, so that no two
                                          // directions tie
        const float bar = static_cast<float>(5 * x + 13 * y);
        const float disc = std::hypot(static_cast<float>(x) - 21.3f, static_cast<float>(y) - 9.1f);
        const float gradient = 1e-3f * static_cast<float>(x) + 2.3e-3f * static_cast<float>(y);
        return ((bar > 250 && bar < 330) || disc < 5.2f ? 0.8f : 0.2f) + gradient;
    };
    const Image upright = filter(size, size, scene);
    const auto last = size - 1;
    const Image mirrored = filter(size, size, [&](int x, int y) { return scene(last - x, y); });
    const Image turned = filter(size, size, [&](int x, int y) { return scene(y, x); });
    double changed = 0;
    for (int y = 0; y < size; ++y) {
        for (int x = 0; x < size; ++x) {
            EXPECT_NEAR(upright.at(x, y, 0), mirrored.at(last - x, y, 0), kHalf);
            EXPECT_NEAR(upright.at(x, y, 0), turned.at(y, x, 0), kHalf);
            changed += std::abs(upright.at(x, y, 0) - scene(x, y));
        }
    }
    EXPECT_GT(changed, 5.0) << "edges were smoothed";
}

TEST_F(FxaaTest, SpecksAreBlurredAsMuchAsAsked) {
    const auto speck = [](int x, int y) { return x == 4 && y == 4 ? 1.0f : 0.0f; };
    const float kept = filter(9, 9, speck, without_blur()).at(4, 4, 0);
    const float blurred = filter(9, 9, speck).at(4, 4, 0);
    EXPECT_NEAR(kept, 1.0f, kHalf) << "its ends are equally near: the edge does not lean";
    EXPECT_NEAR(blurred, 1.0f - 0.75f, kHalf) << "offset = subpixel for a lone pixel";
}

} // namespace
} // namespace ockham::test

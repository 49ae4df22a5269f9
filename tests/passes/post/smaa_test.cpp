// SPDX-License-Identifier: Apache-2.0
// SMAA on edges whose smoothed pictures are known: staircases become the exact coverage of the line
// behind them, plateaus and open ends the triangles of the paper, and flat parts keep their bits.
#include "framework/core/image.hpp"
#include "passes/post/display.hpp"
#include "passes/post/smaa.hpp"
#include "shaders/post/smaa.h"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/pass_bench.hpp"

#include <glm/glm.hpp>

#include <algorithm>
#include <functional>

namespace ockham::test {
namespace {

constexpr float kDark = 0.04f, kBright = 0.64f; // linear
constexpr float kHalf = 1e-3f;                  // rounding of weights

class SmaaTest : public GpuTest {
protected:
    struct Pictures {
        Image edges, radiance;
    };
    /// `radiance`: linear grey of a pixel.
    static Pictures filter(
        std::uint32_t width, std::uint32_t height, const std::function<float(int, int)>& radiance) {
        std::vector<glm::vec4> pixels;
        for (std::uint32_t i = 0; i < width * height; ++i) {
            const float v = radiance(static_cast<int>(i % width), static_cast<int>(i / width));
            pixels.emplace_back(v, v, v, 1.0f);
        }
        PassBench bench(device());
        const ImageHandle in =
            bench.image("radiance", VK_FORMAT_R32G32B32A32_SFLOAT, width, height, pixels);
        const Smaa out = add_smaa(bench.graph, in, add_display(bench.graph, in));
        bench.graph.export_resource(out.edges, "test");
        bench.graph.export_resource(out.radiance, "test");
        bench.execute();
        return {bench.read(out.edges), bench.read(out.radiance)};
    }
    /// Share of bright in a filtered pixel.
    static float coverage(const Image& image, int x, int y) {
        return (image.at(x, y, 0) - kDark) / (kBright - kDark);
    }
    static float shade(bool bright) { return bright ? kBright : kDark; }
    /// The same picture upright, mirrored in x, in y, and turned: `check` gets its coverage.
    static void in_all_directions(int size, const std::function<bool(int, int)>& bright,
        const std::function<void(const std::function<float(int, int)>&)>& check) {
        for (int direction = 0; direction < 8; ++direction) {
            SCOPED_TRACE(testing::Message() << "direction " << direction);
            const auto place = [=](int x, int y) {
                if (direction & 1) x = size - 1 - x;
                if (direction & 2) y = size - 1 - y;
                if (direction & 4) std::swap(x, y);
                return glm::ivec2(x, y);
            };
            const auto back = [=](int x, int y) { // the inverse of place
                if (direction & 4) std::swap(x, y);
                if (direction & 1) x = size - 1 - x;
                if (direction & 2) y = size - 1 - y;
                return glm::ivec2(x, y);
            };
            const auto width = static_cast<std::uint32_t>(size);
            const Image picture = filter(width, width, [&](int x, int y) {
                const glm::ivec2 p = back(x, y);
                return shade(bright(p.x, p.y));
            }).radiance;
            check([&](int x, int y) {
                const glm::ivec2 p = place(x, y);
                return coverage(picture, p.x, p.y);
            });
        }
    }
};

TEST_F(SmaaTest, FlatAndFaintPicturesKeepTheirBits) {
    for (const auto& [width, height] : {std::pair{1u, 1u}, {7u, 5u}, {64u, 64u}}) {
        const auto faint = [](int x, int) { return srgb_decode(x % 2 ? 0.5f : 0.41f); };
        const Image picture = filter(width, height, faint).radiance;
        for (int y = 0; y < picture.height(); ++y) {
            for (int x = 0; x < picture.width(); ++x) ASSERT_EQ(picture.at(x, y, 0), faint(x, y));
        }
    }
}

TEST_F(SmaaTest, EdgesLieLeftAndAboveAndGiveWayToStrongerOnes) {
    // Luma 0, 0, 1 | 0.8 | 0.2: the step of 0.2 from 1 to 0.8 stands beside larger ones.
    const float lumas[] = {0.0f, 0.0f, 1.0f, 0.8f, 0.2f, 0.2f};
    const Image columns = filter(6, 3, [&](int x, int) { return srgb_decode(lumas[x]); }).edges;
    const Image rows = filter(3, 6, [&](int, int y) { return srgb_decode(lumas[y]); }).edges;
    for (int i = 0; i < 6; ++i) {
        const bool edge = i == 2 || i == 4;
        EXPECT_EQ(columns.at(i, 1, 0), edge ? float(SMAA_EDGE_LEFT) : 0.0f) << i;
        EXPECT_EQ(rows.at(1, i, 0), edge ? float(SMAA_EDGE_TOP) : 0.0f) << i;
    }
}

TEST_F(SmaaTest, StaircasesBecomeTheCoverageOfTheirLine) {
    // Z patterns: a line of slope 1 / run through the middles of the steps' edges. What it cuts off
    // a pixel is a triangle or a trapezoid.
    const int size = 40;
    for (const int run : {1, 3, 10}) {
        SCOPED_TRACE(testing::Message() << "run " << run);
        in_all_directions(
            size, [=](int x, int y) { return y >= 8 + x / run; },
            [=](const auto& at) {
                for (int x = 2 * run; x < size - 2 * run && 8 + x / run < size - 1; ++x) {
                    const int row = 8 + x / run;
                    // Height of the line over the row's top edge at the column's borders.
                    const auto r = static_cast<float>(run), d = static_cast<float>(x % run);
                    const float left = 0.5f - d / r, right = 0.5f - (d + 1.0f) / r;
                    const float above = left >= 0 && right >= 0 ? 0.5f * (left + right)
                                        : left > 0              ? 0.5f * left * left * r
                                                                : 0.0f;
                    const float below = above - 0.5f * (left + right);
                    EXPECT_NEAR(at(x, row - 1), above, kHalf) << "above, column " << x;
                    EXPECT_NEAR(at(x, row), 1.0f - below, kHalf) << "below, column " << x;
                }
            });
    }
}

TEST_F(SmaaTest, DiagonalsOfUnequalStepsBecomeTheCoverageOfOneLine) {
    // Slopes 2/3, 3/4, 4/5: among single steps one of two pixels, through whose middle the line
    // runs. Single patterns would bend it at every step.
    const int size = 40;
    for (const int rise : {2, 3, 4}) {
        SCOPED_TRACE(testing::Message() << "slope " << rise << " / " << rise + 1);
        const int period = rise + 1;
        const auto step = [=](int x) { return 4 + x * rise / period; };
        in_all_directions(
            size, [=](int x, int y) { return y >= step(x); },
            [=](const auto& at) {
                for (int x = 2 * period; x < size - 2 * period; ++x) {
                    for (int y = step(x) - 2; y <= std::min(step(x) + 2, size - 1); ++y) {
                        // Bright below the line: the pixel's area there, by strips.
                        double expected = 0;
                        for (int i = 0; i < 256; ++i) {
                            const double line = 4.0 + (x + (i + 0.5) / 256 - 1.0) * rise / period;
                            expected += std::clamp(y + 1 - line, 0.0, 1.0) / 256;
                        }
                        EXPECT_NEAR(at(x, y), expected, kHalf) << x << ", " << y;
                    }
                }
            });
    }
}

TEST_F(SmaaTest, RightAnglesKeepTheirCorners) {
    in_all_directions(
        32, [](int x, int y) { return x >= 10 && x < 22 && y >= 10 && y < 22; },
        [](const auto& at) {
            // The corner's line falls from half a pixel to zero over six: 11/24 of the first pixel.
            const float lost = SMAA_CORNER * 11.0f / 24.0f;
            for (const int x : {10, 21})
                for (const int y : {10, 21}) EXPECT_NEAR(at(x, y), 1.0f - lost, kHalf);
            EXPECT_NEAR(at(9, 10), 0.0f, kHalf) << "nothing gains";
        });
}

TEST_F(SmaaTest, PlateausAndOpenEndsBecomeTriangles) {
    const int size = 32;
    // U: a step up of `length` pixels; the line runs from half a pixel below its corners to the
    // middle of its edge.
    for (const int length : {6}) {
        in_all_directions(
            size, [=](int x, int y) { return y >= 16 || (y == 15 && x >= 10 && x < 10 + length); },
            [=](const auto& at) {
                const float half = 0.5f * static_cast<float>(length);
                for (int d = 0; d < length / 2; ++d) {
                    const float lost = 0.5f * (1.0f - (static_cast<float>(d) + 0.5f) / half);
                    EXPECT_NEAR(at(10 + d, 15), 1.0f - lost, kHalf) << length << ", " << d;
                    EXPECT_NEAR(at(9 + length - d, 15), 1.0f - lost, kHalf);
                }
                EXPECT_NEAR(at(9 + length / 2, 14), 0.0f, kHalf) << "nothing gains";
            });
    }
    // L: one step, whose edge runs on to the picture's border to both sides.
    in_all_directions(
        size, [](int x, int y) { return y >= (x < 20 ? 16 : 15); },
        [=](const auto& at) {
            // Left of the step the lower edge reaches 20 pixels; its line falls from half a pixel
            // above to zero in the middle.
            for (int x = 11; x < 20; ++x) {
                const float gained = 0.5f * (1.0f - (19.5f - static_cast<float>(x)) / 10.0f);
                EXPECT_NEAR(at(x, 15), gained, kHalf) << x;
            }
            EXPECT_NEAR(at(9, 15), 0.0f, kHalf);
            for (int x = 20; x < 26; ++x) {
                const float lost = 0.5f * (1.0f - (static_cast<float>(x) - 19.5f) / 6.0f);
                EXPECT_NEAR(at(x, 15), 1.0f - lost, kHalf) << x;
            }
        });
}

TEST_F(SmaaTest, EdgesBeyondReachAreLeftAlone) {
    const int size = 2 * SMAA_REACH + 40;
    const Image picture = filter(static_cast<std::uint32_t>(size), 8, [](int x, int y) {
        return shade(y >= (x < 1 ? 4 : x < size - 1 ? 3 : 2));
    }).radiance;
    // The pixel in the middle sees neither end: no line, no weight.
    EXPECT_EQ(picture.at(size / 2, 3, 0), kBright);
    EXPECT_EQ(picture.at(size / 2, 2, 0), kDark);
}

} // namespace
} // namespace ockham::test

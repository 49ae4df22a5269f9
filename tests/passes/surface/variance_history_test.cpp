// SPDX-License-Identifier: Apache-2.0
// Hysteresis of the expected variance: at once up, little by little down, along with the surface.
#include "framework/core/image.hpp"
#include "passes/surface/frame.hpp"
#include "passes/surface/variance_history.hpp"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/pass_bench.hpp"
#include "tests/support/surface_scenes.hpp"

#include <bit>
#include <vector>

namespace ockham::test {
namespace {

constexpr std::uint32_t kWidth = 12, kHeight = 5, kPixels = kWidth * kHeight;
constexpr float kKeep = 0.5f;

/// A sequence of frames seen by a camera that moves by `step` between every two.
class Sequence {
public:
    Sequence(gpu::Device& device, const Camera& camera, glm::vec3 step, float stored_depth)
        : bench_(device) {
        Camera before = camera;
        before.position -= step;
        const glm::uvec2 surface(std::bit_cast<std::uint32_t>(stored_depth), 0);
        variance_ = bench_.image(
            "variance", VK_FORMAT_R32G32_SFLOAT, kWidth, kHeight, std::vector<glm::vec2>(kPixels));
        out_ = add_variance_history(bench_.graph,
            {bench_.buffer("frame", std::vector{frame_of(camera)}),
                bench_.buffer("frame_before", std::vector{frame_of(before)}), variance_,
                bench_.image("first_surface", VK_FORMAT_R32G32_UINT, kWidth, kHeight,
                    std::vector<glm::uvec2>(kPixels, surface))},
            kKeep);
        bench_.graph.export_resource(out_, "test");
    }
    /// The steadied variance of the next frame.
    Image next(const std::vector<glm::vec2>& variance) {
        bench_.set(variance_, variance);
        bench_.execute();
        return bench_.read(out_);
    }

private:
    static shader::FrameData frame_of(const Camera& camera) {
        Bounds bounds;
        bounds.add(glm::vec3(-50.0f));
        bounds.add(glm::vec3(50.0f));
        return make_frame({}, bounds, camera, kWidth, kHeight, 2, paper_order(2), 1);
    }

    PassBench bench_;
    ImageHandle variance_, out_;
};

std::vector<glm::vec2> one_pixel(std::uint32_t x, std::uint32_t y, glm::vec2 value) {
    std::vector<glm::vec2> texels(kPixels);
    texels[y * kWidth + x] = value;
    return texels;
}

class VarianceHistoryTest : public GpuTest {};

TEST_F(VarianceHistoryTest, RisesAtOnceAndFallsByTheShareNotKept) {
    Sequence frames(device(), pixel_camera(kWidth, kHeight), glm::vec3(0.0f), 0.5f);
    const std::vector<glm::vec2> nothing(kPixels);
    EXPECT_EQ(frames.next(one_pixel(3, 2, {0.25f, 0.0f})).at(3, 2, 0), 0.25f);
    EXPECT_EQ(frames.next(nothing).at(3, 2, 0), 0.125f);
    EXPECT_EQ(frames.next(one_pixel(3, 2, {0.03125f, 0.0f})).at(3, 2, 0), 0.078125f);
    EXPECT_EQ(frames.next(one_pixel(3, 2, {0.5f, 0.0f})).at(3, 2, 0), 0.5f);
    const Image last = frames.next(nothing);
    for (int y = 0; y < last.height(); ++y)
        for (int x = 0; x < last.width(); ++x)
            EXPECT_EQ(last.at(x, y, 0), x == 3 && y == 2 ? 0.25f : 0.0f);
}

TEST_F(VarianceHistoryTest, FollowsTheSurfaceAndForgetsWhatWasOutOfSight) {
    // One world unit is a pixel: what is at x now was at x + 1.
    Sequence frames(device(), pixel_camera(kWidth, kHeight), glm::vec3(1, 0, 0), 0.5f);
    const std::vector<glm::vec2> nothing(kPixels);
    frames.next(one_pixel(4, 1, {0.5f, 0.0f}));
    const Image first = frames.next(nothing), second = frames.next(nothing);
    for (int y = 0; y < first.height(); ++y) {
        for (int x = 0; x < first.width(); ++x) {
            EXPECT_EQ(first.at(x, y, 0), x == 3 && y == 1 ? 0.25f : 0.0f) << x << ", " << y;
            EXPECT_EQ(second.at(x, y, 0), x == 2 && y == 1 ? 0.125f : 0.0f) << x << ", " << y;
        }
    }
    frames.next(one_pixel(kWidth - 1, 1, {0.5f, 0.0f}));
    EXPECT_EQ(frames.next(nothing).at(kWidth - 1, 1, 0), 0.0f) << "was outside of the picture";
}

TEST_F(VarianceHistoryTest, BackgroundStaysWhereACameraOnlyMoves) {
    const Camera camera = look_at({0, 0, 10}, {0, 0, 0}, 40);
    Sequence frames(device(), camera, glm::vec3(5, 0, 0), 0.0f);
    frames.next(one_pixel(4, 1, {0.5f, 0.0f}));
    EXPECT_EQ(frames.next(std::vector<glm::vec2>(kPixels)).at(4, 1, 0), 0.25f);
}

TEST_F(VarianceHistoryTest, SurfacesAreCountedInTheWindowOfNow) {
    // Between surfaces: the number of surfaces less one stands in the two lowest bits.
    const auto between = [](float value, std::uint32_t others) {
        return std::bit_cast<float>((std::bit_cast<std::uint32_t>(value) & ~3u) | others);
    };
    Sequence frames(device(), pixel_camera(kWidth, kHeight), glm::vec3(0.0f), 0.5f);
    frames.next(one_pixel(3, 2, {0.0f, between(0.25f, 3)}));
    const float two = frames.next(one_pixel(3, 2, {0.0f, between(0.0f, 1)})).at(3, 2, 1);
    EXPECT_EQ(std::bit_cast<std::uint32_t>(two) & 3u, 1u);
    EXPECT_NEAR(two, 0.125f, 1e-6f);
    EXPECT_EQ(frames.next(one_pixel(3, 2, {0.0f, 0.0f})).at(3, 2, 1), 0.0f) << "one surface now";
}

} // namespace
} // namespace ockham::test

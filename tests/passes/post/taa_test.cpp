// SPDX-License-Identifier: Apache-2.0
// Temporal accumulation: jittered frames see what they say they see, a still camera's history is
// their plain mean, and a moving one's stays within what it shows now.
#include "passes/pipelines/adaptive_aa.hpp"
#include "passes/post/taa.hpp"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/surface_scenes.hpp"

#include <algorithm>
#include <cmath>

namespace ockham::test {
namespace {

/// The rectangle [0, 10 + 9/16] x [0, 5 + 5/18] of an xy plane, and sky. Its edges stay 1/18 of a
/// pixel off all samples of the first seven frames: drivers snap vertices to 1/16.
Scene square() {
    Scene scene;
    scene.background = {0.25f, 0.5f, 1.0f};
    scene.materials = {unlit_material({1.0f, 0.75f, 0.0f})};
    add(scene, rectangle({0, 0, 0}, {10.5625f, 0, 0}, {0, 5.0f + 5.0f / 18.0f, 0}));
    return scene;
}

class TaaTest : public GpuTest {
protected:
    static AdaptiveAaParams params(std::uint32_t width, std::uint32_t height) {
        AdaptiveAaParams p;
        p.width = width;
        p.height = height;
        p.method = AaMethod::taa;
        return p;
    }
};

TEST_F(TaaTest, JitterIsLowDiscrepancyAroundTheCentre) {
    EXPECT_EQ(taa_jitter(0), glm::vec2(0.0f, 1.0f / 3.0f - 0.5f));
    glm::vec2 sum(0.0f);
    int quadrants[4]{};
    for (std::uint32_t i = 0; i < 64; ++i) {
        const glm::vec2 j = taa_jitter(i);
        ASSERT_TRUE(std::abs(j.x) <= 0.5f && std::abs(j.y) <= 0.5f);
        sum += j;
        ++quadrants[(j.x < 0 ? 0 : 1) + (j.y < 0 ? 0 : 2)];
    }
    EXPECT_LT(glm::length(sum / 64.0f), 0.03f);
    for (const int count : quadrants) EXPECT_NEAR(count, 16, 3);
}

TEST_F(TaaTest, StillCamerasGatherThePlainMeanOfTheirFrames) {
    const LitScene lit(device(), square());
    AdaptiveAa aa(device(), lit, pixel_camera(16, 8), params(16, 8));
    int inside_x = 0, inside_y = 0;
    for (std::uint32_t frame = 0; frame < 7; ++frame) {
        aa.execute();
        // Column 10 is covered up to 1/16 beyond its middle; row 2 shows y in [5, 6].
        inside_x += taa_jitter(frame).x < 0.0625f;
        inside_y += taa_jitter(frame).y > 4.0f / 18.0f;
        if (frame != 0 && frame != 3 && frame != 6) continue;
        const Image picture = aa.picture();
        const float x = static_cast<float>(inside_x) / static_cast<float>(frame + 1);
        const float y = static_cast<float>(inside_y) / static_cast<float>(frame + 1);
        EXPECT_NEAR(picture.at(10, 5, 3), x, 1e-5f) << frame;
        EXPECT_NEAR(picture.at(10, 5, 0), 0.25f + 0.75f * x, 1e-5f) << frame;
        EXPECT_NEAR(picture.at(4, 2, 3), y, 1e-5f) << frame;
        EXPECT_EQ(picture.at(4, 5, 0), 1.0f) << "inside";
        EXPECT_EQ(picture.at(14, 1, 0), 0.25f) << "sky";
    }
}

TEST_F(TaaTest, MovingCamerasFollowSurfacesAndForgetWhatIsGone) {
    const LitScene lit(device(), square());
    for (const bool orthographic : {true, false}) {
        Camera camera = orthographic ? pixel_camera(16, 8) : look_at({8, 4, 20}, {8, 4, 0}, 22);
        AdaptiveAa aa(device(), lit, camera, params(16, 8));
        for (int frame = 0; frame < 12; ++frame) {
            camera.position.x += 0.4f;
            aa.set_camera(camera);
            aa.execute();
            const Image picture = aa.picture();
            for (int i = 0; i < static_cast<int>(picture.pixels()); ++i) {
                // Nothing but mixtures of surface and sky, as alpha says.
                const float a = picture.plane("A")[std::size_t(i)];
                ASSERT_TRUE(a >= -1e-6f && a <= 1.0f + 1e-6f) << frame;
                ASSERT_NEAR(picture.plane("R")[std::size_t(i)], 0.25f + 0.75f * a, 1e-4f);
                ASSERT_NEAR(picture.plane("B")[std::size_t(i)], 1.0f - a, 1e-4f);
            }
        }
        // A cut to where everything is sky: the clamp leaves nothing of the square.
        camera.position.x += 100.0f;
        aa.set_camera(camera);
        aa.execute();
        const Image cut = aa.picture();
        for (const float a : cut.plane("A")) ASSERT_EQ(a, 0.0f);
    }
}

} // namespace
} // namespace ockham::test

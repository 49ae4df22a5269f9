// SPDX-License-Identifier: Apache-2.0
// Shadows of the sun: where they must be, how sharp they are, and that nothing shades itself.
#include "passes/pipelines/adaptive_aa.hpp"
#include "passes/surface/shadow_map.hpp"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/surface_scenes.hpp"

#include <cmath>
#include <numbers>

namespace ockham::test {
namespace {

class ShadowMapTest : public GpuTest {
protected:
    static Image render(
        const LitScene& lit, const Camera& camera, std::uint32_t width, std::uint32_t height) {
        AdaptiveAaParams params;
        params.width = width;
        params.height = height;
        params.method = AaMethod::none;
        AdaptiveAa aa(device(), lit, camera, params);
        aa.execute();
        return aa.picture();
    }
    static Light sun(glm::vec3 direction, bool casts_shadow = true) {
        Light light;
        light.type = LightType::directional;
        light.direction = glm::normalize(direction);
        light.casts_shadow = casts_shadow;
        return light;
    }
    static Material matt() {
        Material material;
        material.metallic = 0;
        return material;
    }
    /// A floor of 64 x 64 in the plane z = 0 and a blocker of 10 x 10, 8 above it. The sun stands
    /// so that the shadow lies 8 to the right of the blocker.
    static Scene floor_and_blocker(Material blocker) {
        Scene scene;
        scene.materials = {matt(), blocker};
        add(scene, rectangle({0, 0, 0}, {64, 0, 0}, {0, 64, 0}));
        add(scene, rectangle({20, 20, 8}, {10, 0, 0}, {0, 10, 0}, 1));
        scene.lights = {sun({1, 0, -1})};
        return scene;
    }
    /// Orthographic view straight down on `center`, `size` world units high.
    static Camera above(glm::vec2 center, float size) {
        Camera camera;
        camera.position = {center, 100};
        camera.orthographic_height = size;
        return camera;
    }
};

TEST_F(ShadowMapTest, BlockerTakesTheSunAndNothingElse) {
    const LitScene lit(device(), floor_and_blocker(matt()));
    const Image picture = render(lit, above({32, 32}, 64), 64, 64);
    const float sunlit = picture.at(5, 5, 0);
    EXPECT_GT(sunlit, 0.1f);
    for (int y = 0; y < 64; ++y) {
        for (int x = 0; x < 64; ++x) {
            const float row = 63.5f - static_cast<float>(y), column = static_cast<float>(x) + 0.5f;
            const bool blocked = row > 20 && row < 30 && column > 30 && column < 38;
            ASSERT_NEAR(picture.at(x, y, 0), blocked ? 0.0f : sunlit, 1e-5f * sunlit)
                << column << ", " << row;
        }
    }
}

TEST_F(ShadowMapTest, ShadowEdgeIsTwoTexelsWide) {
    const LitScene lit(device(), floor_and_blocker(matt()));
    const shader::FrameData frame = make_frame(
        lit.scene(), lit.gpu().bounds(), above({0, 0}, 1), 1, 1, 1, {0}, LitScene::kShadowMapSize);
    const float texel = frame.sun_texel;
    EXPECT_LT(texel, 0.03f);
    // Across the shadow's right edge at x = 38, eight pixels to a texel. A texel perpendicular to
    // the sun covers 1.41 of the floor.
    constexpr std::uint32_t kWidth = 128;
    const float size = static_cast<float>(kWidth) / 8 * texel;
    const Image picture = render(lit, above({38, 25}, size / 2), kWidth, kWidth / 2);
    const float sunlit = picture.at(kWidth - 1, 10, 0);
    EXPECT_EQ(picture.at(0, 10, 0), 0.0f);
    EXPECT_GT(sunlit, 0.1f);
    int partial = 0;
    float last = 0;
    for (int x = 0; x < static_cast<int>(kWidth); ++x) {
        const float v = picture.at(x, 10, 0);
        EXPECT_GE(v, last - 1e-5f) << "monotone";
        last = v;
        partial += v > 1e-5f && v < sunlit * (1 - 1e-5f);
    }
    EXPECT_GT(partial, 0) << "interpolated";
    EXPECT_LE(partial, 2 * 8 * 1.415f);
}

TEST_F(ShadowMapTest, FlatAndCurvedSurfacesDoNotShadeThemselves) {
    // A plane and a wavy sheet that faces the sun everywhere, at many slopes: with and without a
    // shadow map they look the same, bit for bit.
    for (const float slope : {0.0f, 0.5f, 1.0f, 2.0f, 4.0f}) {
        Scene scene;
        scene.materials = {matt()};
        add(scene, rectangle({-8, -8, 0}, {16, 0, 0}, {0, 16, 0}));
        scene.lights = {sun({slope, 0.3f * slope, -1})};
        Scene unshadowed = scene;
        unshadowed.lights[0].casts_shadow = false;
        const LitScene with(device(), scene), without(device(), unshadowed);
        ASSERT_NE(with.shadow_map(), nullptr);
        ASSERT_EQ(without.shadow_map(), nullptr);
        const Camera camera = look_at({2, -9, 7}, {0, 0, 0}, 55);
        const Image a = render(with, camera, 96, 72), b = render(without, camera, 96, 72);
        std::size_t darker = 0;
        for (std::size_t i = 0; i < a.pixels(); ++i) darker += a.plane("G")[i] != b.plane("G")[i];
        EXPECT_EQ(darker, 0u) << "slope " << slope;
    }
}

TEST_F(ShadowMapTest, HolesOfAMaskLetTheSunThrough) {
    Scene scene = floor_and_blocker(matt());
    Material& blocker = scene.materials[1];
    blocker.masked = true;
    blocker.base_color_texture.image = add_image(
        scene, 16, 16, [](int x, int) { return glm::u8vec4(255, 255, 255, x < 8 ? 255 : 0); });
    const LitScene lit(device(), scene);
    const Image picture = render(lit, above({32, 32}, 64), 64, 64);
    const float sunlit = picture.at(5, 5, 0);
    // The left half of the blocker, x = 20 ... 25, throws its shadow on 28 ... 33.
    EXPECT_EQ(picture.at(31, 38, 0), 0.0f);
    EXPECT_NEAR(picture.at(35, 38, 0), sunlit, 1e-5f * sunlit);
}

TEST_F(ShadowMapTest, SingleSidedSurfacesShadeFromBothSides) {
    Scene scene = floor_and_blocker(matt());
    // Turned over: the camera sees through it, the sun does not.
    scene.meshes[1].primitives[0] = rectangle({30, 20, 8}, {-10, 0, 0}, {0, 10, 0}, 1);
    const LitScene lit(device(), scene);
    const Image picture = render(lit, above({32, 32}, 64), 64, 64);
    const float sunlit = picture.at(5, 5, 0);
    EXPECT_EQ(picture.at(35, 38, 0), 0.0f);
    EXPECT_NEAR(picture.at(24, 38, 0), sunlit, 1e-5f * sunlit) << "seen through the back face";
}

TEST_F(ShadowMapTest, SceneWithoutSunOrShadowHasNoMap) {
    Scene scene = floor_and_blocker(matt());
    scene.lights[0].casts_shadow = false;
    EXPECT_EQ(LitScene(device(), scene).shadow_map(), nullptr);
    scene.lights[0].casts_shadow = true;
    EXPECT_NE(LitScene(device(), scene).shadow_map(), nullptr);
    scene.meshes.clear();
    scene.instances.clear();
    EXPECT_EQ(LitScene(device(), scene).shadow_map(), nullptr) << "nothing to throw a shadow";
}

} // namespace
} // namespace ockham::test

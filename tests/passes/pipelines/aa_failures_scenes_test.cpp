// SPDX-License-Identifier: Apache-2.0
// Where adaptive anti-aliasing breaks, in scenes with textures, shadows and highlights: fences that
// recede, leaf cards, shadow edges. The numbers of the rows are those of docs/testing.md; what
// needs flat colours only is in aa_failures_test.cpp.
#include "framework/core/rng.hpp"
#include "framework/image_error/flicker.hpp"
#include "framework/image_error/image_error.hpp"
#include "framework/image_error/mse.hpp"
#include "framework/scene/builtin.hpp"
#include "tests/passes/pipelines/aa_failures.hpp"

#include <numbers>

namespace ockham::test {
namespace {

class AaFailuresScenes : public AaFailures {};

// Row 3: fences that run to the horizon. Their far ends are smaller than a pixel.
TEST_F(AaFailuresScenes, FenceToTheHorizon) {
    constexpr int kWidth = 96, kHeight = 72, kTop = 30, kRows = 8; // the horizon: row 34
    const LitScene lit(device(), builtin_scene("fence"));
    const Camera& camera = lit.scene().cameras.front();
    const double right = mean(truth(lit, camera, kWidth, kHeight), kTop, kRows);
    const auto error = [&](const Picture& picture) {
        return std::abs(mean(picture.radiance, kTop, kRows) / right - 1.0);
    };
    const Picture picture = render(lit, camera, paper(kWidth, kHeight));
    EXPECT_LT(error(picture), 0.01);
    EXPECT_GT(picture.percent, 25.0) << "no bound: whatever has depth gets all samples";
    int full = 0;
    for (int x = 0; x < kWidth; ++x) full += picture.k(x, 33) == 16;
    EXPECT_GT(full, kWidth / 3) << "at the horizon";
    AdaptiveAaParams bounded = ours(kWidth, kHeight);
    bounded.budget = 20.0f;
    const Picture better = render(lit, camera, bounded);
    EXPECT_LT(error(better), 0.01);
    EXPECT_LE(better.percent, 20.5);
}

// Row 13: cards with a disc cut out by alpha, of 24 to 3 pixels.
TEST_F(AaFailuresScenes, LeafCardsKeepTheirCoverage) {
    constexpr int kSize = 96, kSide = 128;
    for (const float card : {24.0f, 12.0f, 6.0f, 3.0f}) {
        SCOPED_TRACE(card);
        Scene scene;
        scene.materials = {unlit_material()};
        scene.materials[0].masked = true;
        scene.materials[0].base_color_texture.image =
            add_image(scene, kSide, kSide, [](int x, int y) {
                const double dx = x + 0.5 - kSide / 2, dy = y + 0.5 - kSide / 2;
                const double inside = 0.4 * kSide - std::sqrt(dx * dx + dy * dy);
                const double alpha = std::clamp(inside + 0.5, 0.0, 1.0);
                return glm::u8vec4(255, 255, 255, static_cast<unsigned char>(255 * alpha + 0.5));
            });
        int cards = 0;
        const float step = 1.25f * card + 0.13f; // every place in the pixel's grid
        for (float y = 1; y + card < kSize; y += step)
            for (float x = 1; x + card < kSize; x += step, ++cards)
                add(scene, rectangle({x, y, 0}, {card, 0, 0}, {0, card, 0}));
        const double disc = std::numbers::pi * 0.4 * card * 0.4 * card * cards;
        const LitScene lit(device(), scene);
        const Camera camera = pixel_camera(kSize, kSize);
        const auto covered = [&](const AdaptiveAaParams& p) {
            return mean(render(lit, camera, p).radiance, 0, kSize) * kSize * kSize;
        };
        // At 3 pixels the samples ask for an image of 12 texels: half a texel of the rim is 5 %.
        const double tolerance = card > 3 ? 0.02 : 0.06;
        EXPECT_NEAR(covered(all_samples(kSize, kSize)) / disc, 1.0, tolerance);
        EXPECT_NEAR(covered(paper(kSize, kSize)) / disc, 1.0, tolerance);
        EXPECT_NEAR(covered(ours(kSize, kSize)) / disc, 1.0, tolerance);
    }
}

// Row 22: a hard shadow on a flat wall, of something out of sight.
TEST_F(AaFailuresScenes, ShadowEdgeOnAFlatWall) {
    constexpr int kSize = 32, kEdge = 25; // row of the edge: 6.3 from below
    Scene scene;
    scene.materials = {Material{}};
    scene.materials[0].metallic = 0;
    add(scene, rectangle({-2, -2, 0}, {36, 0, 0}, {0, 36, 0}));
    add(scene, rectangle({-10, 46.3f, 40}, {52, 0, 0}, {0, 40, 0}));
    scene.materials[0].double_sided = true;
    scene.ambient = glm::vec3(0.05f);
    scene.lights.push_back({.name = "sun",
        .type = LightType::directional,
        .direction = glm::normalize(glm::vec3(0, -1, -1)),
        .intensity = glm::vec3(2.0f),
        .casts_shadow = true});
    const LitScene lit(device(), scene);
    const Camera camera = pixel_camera(kSize, kSize);
    const Image full = render(lit, camera, all_samples(kSize, kSize)).radiance;
    ASSERT_LT(full.at(16, 5, 1), 0.2f * full.at(16, 30, 1)) << "shadow above, light below";
    const auto near_edge = [](int, int y) { return std::abs(y - kEdge) <= 1; };
    const auto off_edge = [&](int x, int y) { return !near_edge(x, y); };
    AdaptiveAaParams p = paper(kSize, kSize);
    const Picture picture = render(lit, camera, p);
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x)
            EXPECT_EQ(picture.k(x, y) > 1, near_edge(x, y)) << x << ", " << y;
    EXPECT_LT(largest_error(picture.radiance, full, off_edge), 1e-5f);
    const Picture better = render(lit, camera, ours(kSize, kSize));
    int at_edge = 0;
    for (int y = 0; y < kSize; ++y) {
        for (int x = 0; x < kSize; ++x) {
            if (off_edge(x, y)) {
                EXPECT_EQ(better.k(x, y), 1) << x << ", " << y;
            }
            if (y == kEdge) at_edge += better.k(x, y) > 1;
        }
    }
    EXPECT_EQ(at_edge, kSize);
    EXPECT_LT(largest_error(better.radiance, full, off_edge), 1e-5f);
    p.metrics.shading_weight = 0;
    EXPECT_EQ(render(lit, camera, p).most(), 1) << "nothing in the G-buffer shows it";
}

// Row 14: fine bumps on polished metal. Each of its facets flashes where it mirrors the lamp.
Scene sparkling_plane(int size, float turn) {
    constexpr int kBumps = 64; // of a quarter of a pixel
    Scene scene;
    scene.materials = {Material{}};
    scene.materials[0].metallic = 1;
    scene.materials[0].roughness = 0.05f;
    Pcg32 rng(14);
    scene.materials[0].normal_texture.image = add_image(scene, kBumps, kBumps, [&](int, int) {
        const auto slope = [&] {
            return static_cast<unsigned char>(128 + 20 * (rng.uniform() + rng.uniform() - 1));
        };
        return glm::u8vec4{slope(), slope(), 255, 255}; // braces: in this order
    });
    const auto side = static_cast<float>(size);
    add(scene, rectangle({0, 0, 0}, {side, 0, 0}, {0, side, 0}, 0, glm::vec2(4 * side / kBumps)));
    scene.lights.push_back({.name = "lamp",
        .type = LightType::directional,
        .direction = glm::normalize(glm::vec3(turn, 0.02f, -1)),
        .intensity = glm::vec3(0.01f)});
    return scene;
}

TEST_F(AaFailuresScenes, HighlightsBelowAPixel) {
    constexpr int kSize = 32, kFrames = 4;
    struct Method {
        AdaptiveAaParams p;
        double peak = 0, sum = 0, error = 0;
        double peak_to_mean() const { return peak * kFrames / sum; }
    };
    const AdaptiveAaParams filtered = ours(kSize, kSize);
    AdaptiveAaParams sharp = filtered;
    sharp.filter_highlights = false;
    Method methods[] = {{paper(kSize, kSize)}, {sharp}, {filtered}};
    const Camera camera = pixel_camera(kSize, kSize);
    for (int frame = 0; frame < kFrames; ++frame) {
        const LitScene lit(device(), sparkling_plane(kSize, 0.01f * static_cast<float>(frame)));
        const Image right = truth(lit, camera, kSize, kSize);
        for (Method& method : methods) {
            const Image picture = render(lit, camera, method.p).radiance;
            const std::span<const float> green = picture.plane(1);
            method.peak = std::max<double>(method.peak, *std::ranges::max_element(green));
            method.sum += mean(picture, 0, kSize);
            method.error += mse(displayed(picture), displayed(right)) / kFrames;
        }
    }
    const auto& [printed, unfiltered, ours] = methods;
    EXPECT_LE(ours.peak_to_mean(), printed.peak_to_mean() / 5);
    EXPECT_LT(ours.peak_to_mean(), unfiltered.peak_to_mean() / 2);
    EXPECT_GT(psnr(ours.error), psnr(unfiltered.error) + 3);
    EXPECT_GT(psnr(ours.error), psnr(printed.error) + 3);
}

// Row 16: a camera that moves by a fraction of a pixel per frame, at equal numbers of samples.
TEST_F(AaFailuresScenes, MovingCamerasFlickerLess) {
    constexpr int kWidth = 96, kHeight = 72, kFrames = 5;
    const LitScene lit(device(), builtin_scene("fence"));
    const auto sequence = [&](const AdaptiveAaParams& p, double& percent, double& changed) {
        Camera camera = lit.scene().cameras.front();
        AdaptiveAa aa(device(), lit, camera, p);
        AdaptiveAa all(device(), lit, camera, all_samples(kWidth, kHeight));
        Flicker flicker;
        Image before;
        percent = changed = 0;
        for (int frame = 0; frame < kFrames; ++frame) {
            for (AdaptiveAa* picture : {&aa, &all}) {
                picture->set_camera(camera);
                picture->execute();
            }
            flicker.add(aa.picture(), all.picture());
            Image counts = aa.executor().read(aa.outputs().sample_count);
            if (!before.empty())
                changed += share_changed(before.plane(0), counts.plane(0), 2) / (kFrames - 1);
            percent += aa.sample_counts().percent / kFrames;
            before = std::move(counts);
            camera.position += glm::vec3(0.004f, 0.001f, 0.0f);
        }
        return flicker.rms();
    };
    double percent = 0, ours_percent = 0, changed = 0, ours_changed = 0;
    const double flicker = sequence(paper(kWidth, kHeight), percent, changed);
    AdaptiveAaParams p = ours(kWidth, kHeight);
    p.budget = static_cast<float>(percent);
    p.history = true;
    const double ours_flicker = sequence(p, ours_percent, ours_changed);
    EXPECT_LE(ours_percent, percent + 0.5);
    EXPECT_LT(ours_flicker, 0.7 * flicker) << flicker;
    EXPECT_LT(ours_changed, 0.05) << changed;
}

} // namespace
} // namespace ockham::test

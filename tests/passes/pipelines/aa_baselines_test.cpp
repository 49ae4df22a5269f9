// SPDX-License-Identifier: Apache-2.0
// Baselines as whole pictures: each comes closer to full supersampling than one sample per pixel
// does, and declares only its own passes.
#include "framework/graph/explain/explain.hpp"
#include "framework/image_error/image_error.hpp"
#include "passes/pipelines/adaptive_aa.hpp"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/surface_scenes.hpp"

#include <cmath>

namespace ockham::test {
namespace {

/// Flat polygons with long edges at many angles: what filters of a picture are made for.
Scene fans() {
    Scene scene;
    scene.background = {0.1f, 0.12f, 0.2f};
    scene.materials = {unlit_material({0.8f, 0.6f, 0.2f}), unlit_material({0.05f, 0.3f, 0.1f})};
    for (int i = 0; i < 12; ++i) {
        const float from = 0.5236f * static_cast<float>(i) + 0.07f, to = from + 0.2f;
        add(scene, triangle({0, 0, 0}, {3 * std::cos(from), 3 * std::sin(from), 0},
                       {3 * std::cos(to), 3 * std::sin(to), 0}, i % 2));
    }
    scene.cameras = {look_at({0.1f, 0.2f, 6}, {0.1f, 0.2f, 0}, 45)};
    return scene;
}

class AaBaselinesTest : public GpuTest {
protected:
    static AdaptiveAa make(const LitScene& lit, AaMethod method, std::uint32_t m = 4) {
        AdaptiveAaParams params;
        params.width = 160;
        params.height = 120;
        params.m = m;
        params.method = method;
        params.export_counts = true;
        AdaptiveAa aa(device(), lit, lit.scene().cameras.front(), params);
        aa.execute();
        return aa;
    }
};

TEST_F(AaBaselinesTest, FiltersComeCloserToSupersamplingThanOneSample) {
    const LitScene lit(device(), fans());
    const Image reference = make(lit, AaMethod::ssaa, 8).picture();
    const auto psnr = [&](AaMethod method) {
        return image_error(make(lit, method).picture(), reference).psnr;
    };
    const double none = psnr(AaMethod::none);
    EXPECT_GT(psnr(AaMethod::fxaa), none + 3.0);
    EXPECT_GT(psnr(AaMethod::smaa), none + 5.0);
    EXPECT_GT(psnr(AaMethod::sraa), none + 10.0) << "has 4 x 4 geometry";
}

TEST_F(AaBaselinesTest, FiltersShadeOneSamplePerPixelWhateverM) {
    const LitScene lit(device(), fans());
    for (const AaMethod method : {AaMethod::fxaa, AaMethod::smaa, AaMethod::taa}) {
        AdaptiveAa aa = make(lit, method);
        const auto counts = aa.sample_counts();
        EXPECT_EQ(counts.mean, 1.0);
        EXPECT_EQ(counts.percent, 100.0) << "of the one sample that a pixel has";
        const std::string why = explain(aa.executor().graph().declaration(), aa.executor().plan());
        EXPECT_NE(why.find("one sample per pixel: nothing to decide"), std::string::npos);
        for (const PassTime& time : aa.executor().times()) {
            EXPECT_EQ(is_shading_pass(time.pass), time.pass != "gbuffer") << time.pass;
        }
    }
}

TEST_F(AaBaselinesTest, MultisamplingShadesAllSamplesOfEdgesAndOneElsewhere) {
    const LitScene lit(device(), fans());
    AdaptiveAa aa = make(lit, AaMethod::msaa);
    const Image picture = aa.picture(), all = make(lit, AaMethod::ssaa, 2).picture();
    const auto counts = aa.sample_counts();
    ASSERT_EQ(counts.histogram.size(), 4u);
    EXPECT_EQ(counts.histogram[1] + counts.histogram[2], 0u);
    EXPECT_GT(counts.histogram[0], 4 * counts.histogram[3]);
    EXPECT_GT(counts.histogram[3], 500u);
    // Flat colours: nothing is lost inside of surfaces, and edges have all their samples.
    EXPECT_EQ(image_error(picture, all).mse, 0.0);
}

TEST_F(AaBaselinesTest, OneSampleOfEachSurfaceIsEnoughForFlatColours) {
    const LitScene lit(device(), fans());
    AdaptiveAa aa = make(lit, AaMethod::cluster);
    const Image picture = aa.picture(), all = make(lit, AaMethod::ssaa).picture();
    const auto counts = aa.sample_counts();
    EXPECT_LT(counts.mean, 1.5);
    EXPECT_GT(counts.histogram[1], 500u) << "edges";
    EXPECT_EQ(counts.histogram[4], 0u) << "four surfaces at most";
    // Windows of more than four surfaces, where the fans meet, lump the rest together.
    EXPECT_GT(image_error(picture, all).psnr, 45.0);
}

} // namespace
} // namespace ockham::test

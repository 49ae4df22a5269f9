// SPDX-License-Identifier: Apache-2.0
// What samples take from all of their surface: mean colours against all samples, lobes against the
// formula. What it does to highlights and to pictures: aa_failures_scenes_test, adaptive_aa_test.
#include "framework/core/rng.hpp"
#include "passes/pipelines/adaptive_aa.hpp"
#include "passes/surface/surface_means.hpp"
#include "shaders/shared/scene.h"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/surface_scenes.hpp"
#include "tests/support/surface_windows.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace ockham::test {
namespace {

class SurfaceMeansTest : public GpuTest {
protected:
    static Image render(const LitScene& lit, const AdaptiveAaParams& p) {
        const Camera camera = pixel_camera(p.width, p.height);
        AdaptiveAa aa(device(), lit, camera, p);
        aa.execute();
        return aa.picture();
    }
    static float largest_error(const Image& a, const Image& b) {
        float most = 0;
        for (int c = 0; c < 3; ++c)
            for (std::size_t i = 0; i < a.plane(c).size(); ++i)
                most = std::max(most, std::abs(a.plane(c)[i] - b.plane(c)[i]));
        return most;
    }
};

// Unlit materials are their base colour. With one sample of each surface, weighed by coverage, the
// picture is that of all samples if each sample has its surface's mean, whatever the images hold.
TEST_F(SurfaceMeansTest, ColoursAreTheMeanOfAllSamples) {
    constexpr std::uint32_t kWidth = 24, kHeight = 16;
    Scene scene;
    scene.background = glm::vec3(0.2f, 0.4f, 0.8f);
    scene.materials = {unlit_material(), unlit_material(glm::vec3(0.9f, 0.5f, 0.7f))};
    Pcg32 rng(7);
    for (Material& material : scene.materials) {
        material.base_color_texture.image = add_image(scene, 64, 64, [&](int, int) {
            const auto byte = [&] { return static_cast<unsigned char>(rng.below(256)); };
            return glm::u8vec4(byte(), byte(), byte(), 255);
        });
    }
    add(scene, rectangle({1.3f, 1.6f, 0}, {14, 2, 0}, {-1, 11, 0}, 0));
    add(scene, rectangle({9.2f, 3.1f, 5}, {12, -1, 0}, {2, 10, 0}, 1));
    const LitScene lit(device(), scene);
    const auto check_mean = [&](std::uint32_t m, GbufferLayout layout) {
        SCOPED_TRACE(testing::Message() << "m = " << m << ", layout " << static_cast<int>(layout));
        AdaptiveAaParams p;
        p.width = kWidth;
        p.height = kHeight;
        p.m = m;
        p.gbuffer = layout;
        p.order_kind = SampleOrder::optimal;
        p.method = AaMethod::ssaa;
        const Image all = render(lit, p);
        p.method = AaMethod::cluster;
        EXPECT_GT(largest_error(render(lit, p), all), 0.02f) << "one sample is not the mean";
        p.demodulate = true;
        EXPECT_LT(largest_error(render(lit, p), all), 2e-3f) << "11 and 10 bits of the root";
    };
    check_mean(4, GbufferLayout::packed);
    check_mean(6, GbufferLayout::packed);
    check_mean(3, GbufferLayout::visibility);
}

TEST_F(SurfaceMeansTest, LobesHoldSmallSpreadsOfOneSurface) {
    const std::vector<int> bytes{0, 1, 13, 25, 32, 38, 45, 51, 52, 128, 255};
    const auto count = static_cast<std::uint32_t>(bytes.size());
    // Even rows see one surface, odd rows another in the last sample.
    for (const std::uint32_t m : {2u, 4u, 5u}) {
        SurfaceWindows windows(count, 2, m);
        windows.fill(10);
        const bool wide = windows.n() > 16;
        std::vector<std::uint32_t> labels;
        std::vector<glm::u8vec4> spreads;
        for (std::uint32_t y = 0; y < 2; ++y) {
            for (const int byte : bytes) {
                std::array<std::uint32_t, 4> words{};
                const std::uint32_t last = windows.n() - 1;
                if (y == 1) words[last / 16] = 1u << 2 * (last % 16);
                labels.insert(labels.end(), words.begin(), words.begin() + (wide ? 4 : 1));
                spreads.emplace_back(byte, 200, 0, 0);
            }
        }
        PassBench bench(device());
        SceneInputs scene;
        scene.frame = bench.buffer("frame", std::vector{windows.frame()});
        scene.handles.materials = bench.buffer("materials", std::vector<shader::MaterialData>(1));
        Clusters clusters;
        clusters.labels = bench.image(
            "clusters", wide ? VK_FORMAT_R32G32B32A32_UINT : VK_FORMAT_R32_UINT, count, 2, labels);
        clusters.normal_spread =
            bench.image("normal_spread", VK_FORMAT_R8G8B8A8_UNORM, count, 2, spreads);
        const ImageHandle means = bench.keep(add_surface_means(
            bench.graph, scene, windows.gbuffer(bench), clusters, {.width = count, .height = 2}));
        bench.execute();
        const auto texels = bench.texels<std::uint32_t>(means);
        for (std::size_t i = 0; i < bytes.size(); ++i) {
            const double s = bytes[i] / 255.0;
            const double expected = 2 * s * s * std::clamp(2 - s / 0.1, 0.0, 1.0);
            EXPECT_NEAR(std::bit_cast<float>(texels[i]), expected, 1e-6) << "spread " << s;
            EXPECT_EQ(texels[count + i], 0u) << "several surfaces";
        }
    }
}

} // namespace
} // namespace ockham::test

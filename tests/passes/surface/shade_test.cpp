// SPDX-License-Identifier: Apache-2.0
// Sums over several samples: the first k in the given order, whatever the dispatch, the split into
// rounds, the stall or the lights. Equality of whole pictures: tests/passes/pipelines.
#include "framework/core/rng.hpp"
#include "passes/pipelines/adaptive_aa.hpp"
#include "passes/surface/first_sample.hpp"
#include "passes/surface/shade.hpp"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/scene_bench.hpp"
#include "tests/support/surface_scenes.hpp"

#include <cmath>

namespace ockham::test {
namespace {

/// varied_scene() without images, so that no footprint depends on k.
Scene untextured_scene() {
    Scene scene = varied_scene();
    for (Material& material : scene.materials) {
        for (TextureUse* use :
            {&material.base_color_texture, &material.emissive_texture, &material.normal_texture,
                &material.metallic_roughness_texture, &material.occlusion_texture}) {
            use->image = -1;
        }
    }
    return scene;
}

class ShadeTest : public GpuTest {
protected:
    static Image render(const LitScene& lit, const AdaptiveAaParams& params) {
        AdaptiveAa aa(device(), lit, lit.scene().cameras.front(), params);
        aa.execute();
        return aa.picture();
    }
    static AdaptiveAaParams params(
        std::uint32_t width, std::uint32_t height, std::uint32_t m, AaMethod method) {
        AdaptiveAaParams p;
        p.width = width;
        p.height = height;
        p.m = m;
        p.method = method;
        return p;
    }
};

TEST_F(ShadeTest, UniformTakesTheFirstSamplesOfTheOrder) {
    const LitScene lit(device(), untextured_scene());
    constexpr std::uint32_t kWidth = 17, kHeight = 11;
    for (const std::uint32_t m : {2u, 3u, 4u}) {
        const Image samples = render(lit, params(m * kWidth, m * kHeight, 1, AaMethod::none));
        const std::vector<std::uint32_t> order = paper_order(static_cast<int>(m));
        for (std::uint32_t k = 1; k < m * m; k += m) {
            AdaptiveAaParams p = params(kWidth, kHeight, m, AaMethod::uniform);
            p.k = k;
            const Image picture = render(lit, p);
            for (std::uint32_t y = 0; y < kHeight; ++y) {
                for (std::uint32_t x = 0; x < kWidth; ++x) {
                    for (int c = 0; c < 4; ++c) {
                        float sum = 0;
                        for (std::uint32_t i = 0; i < k; ++i) {
                            sum += samples.at(static_cast<int>(x * m + order[i] % m),
                                static_cast<int>(y * m + order[i] / m), c);
                        }
                        ASSERT_EQ(picture.at(static_cast<int>(x), static_cast<int>(y), c),
                            sum / static_cast<float>(k))
                            << "m = " << m << ", k = " << k << ", pixel " << x << "," << y;
                    }
                }
            }
        }
    }
}

TEST_F(ShadeTest, AnyMapOfCountsGivesTheSameSumsByLoopAndBuckets) {
    const Scene scene = varied_scene();
    constexpr std::uint32_t kWidth = 19, kHeight = 13;
    for (const std::uint32_t m : {2u, 3u, 4u, 8u}) {
        const std::uint32_t n = m * m;
        Pcg32 rng(m);
        std::vector<std::uint8_t> map(kWidth * kHeight);
        for (std::uint8_t& k : map) k = static_cast<std::uint8_t>(1 + rng.below(n));
        std::vector<float> sums[2];
        for (const bool buckets : {false, true}) {
            SceneBench bench(device(), scene, scene.cameras.front(), kWidth, kHeight, m,
                paper_order(static_cast<int>(m)));
            const ShadingInputs in{.scene = bench.inputs,
                .gbuffer = add_gbuffer(bench.graph, bench.inputs, {kWidth, kHeight, m}, 16384),
                .shadow_map = {}};
            const ShadingParams shading{.width = kWidth, .height = kHeight, .m = m};
            const ImageHandle counts =
                bench.image("sample_count", VK_FORMAT_R8_UINT, kWidth, kHeight, map);
            const ImageHandle s = add_first_sample(bench.graph, in, shading);
            const ImageHandle sum =
                buckets ? add_shade_buckets(bench.graph, in, shading, s,
                              add_buckets(bench.graph, counts, {kWidth, kHeight, n}))
                        : add_shade_loop(bench.graph, in, shading, s, counts);
            bench.graph.export_resource(sum, "test");
            bench.execute();
            sums[buckets ? 1 : 0] = interleaved(bench.read(sum));
        }
        for (std::size_t i = 0; i < sums[0].size(); ++i) {
            if (map[i / 4] == 1) continue; // left undefined: S has it
            ASSERT_EQ(sums[0][i], sums[1][i]) << "m = " << m << ", k = " << int{map[i / 4]};
        }
    }
}

TEST_F(ShadeTest, LightsAddUp) {
    // Whatever subset of types the kernel is specialised for, each light adds its share.
    const Scene all = untextured_scene();
    const AdaptiveAaParams p = params(33, 21, 2, AaMethod::ssaa);
    const LitScene lit(device(), all);
    const Image together = render(lit, p);
    Scene dark = all;
    dark.lights.clear();
    const LitScene unlit(device(), dark);
    const Image base = render(unlit, p);
    std::vector<double> sum;
    for (const float v : interleaved(base)) sum.push_back(v);
    for (const Light& light : all.lights) {
        Scene one = all;
        one.lights = {light};
        const LitScene single(device(), one);
        const std::vector<float> picture = interleaved(render(single, p));
        const std::vector<float> ground = interleaved(base);
        double added = 0;
        for (std::size_t i = 0; i < sum.size(); ++i) {
            sum[i] += picture[i] - ground[i];
            added += picture[i] - ground[i];
        }
        EXPECT_GT(added, 1.0) << "the light is seen";
    }
    const std::vector<float> found = interleaved(together);
    for (std::size_t i = 0; i < sum.size(); ++i)
        EXPECT_NEAR(found[i], sum[i], 1e-5 * std::max(1.0, sum[i]));
}

TEST_F(ShadeTest, IterationsOfASampleAreCountedAndRefusedBeyondTheBudget) {
    SceneFacts facts;
    facts.directional_lights = 1;
    facts.point_lights = 24;
    ShadingParams shading{.width = 8, .height = 8, .m = 4, .stall = 2000, .anisotropy = 16};
    EXPECT_EQ(iterations_per_sample(facts, shading), 125u + 25u + 1u);
    facts.color_textures = true; // base colour and emission, 16 taps each
    EXPECT_EQ(iterations_per_sample(facts, shading), 125u + 25u + 32u + 1u);
    EXPECT_EQ(samples_per_dispatch(facts, shading), kIterationBudget / 183);
    shading.stall = 16 * kIterationBudget;
    const std::string text = error_of([&] { samples_per_dispatch(facts, shading); });
    for (const char* part : {"iterations", "stall 800000", "25 lights", "50000", "fewer lights"})
        EXPECT_NE(text.find(part), std::string::npos) << text;
}

TEST_F(ShadeTest, RoundsAreDeclaredOnlyWhereTheBudgetForcesThem) {
    const Scene scene = varied_scene();
    for (const std::uint32_t stall : {0u, 16u * 10000u}) {
        SceneBench bench(device(), scene, scene.cameras.front(), 8, 8, 4, paper_order(4));
        const ShadingInputs in{.scene = bench.inputs,
            .gbuffer = add_gbuffer(bench.graph, bench.inputs, {8, 8, 4}, 16384),
            .shadow_map = {}};
        const ShadingParams shading{.width = 8, .height = 8, .m = 4, .stall = stall};
        add_shade_uniform(bench.graph, in, shading, 16);
        const std::uint32_t per_round = samples_per_dispatch(bench.gpu.facts(), shading);
        std::size_t rounds = 0;
        for (const PassDecl& pass : bench.graph.declaration().passes)
            rounds += pass.name.starts_with("shade");
        EXPECT_EQ(rounds, (16 + per_round - 1) / per_round);
        EXPECT_EQ(rounds, stall == 0 ? 1u : 4u);
    }
}

} // namespace
} // namespace ockham::test

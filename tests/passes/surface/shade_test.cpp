// SPDX-License-Identifier: Apache-2.0
// Sums over several samples: the first k in the given order, whatever the dispatch, the split into
// rounds, the stall or the lights. Equality of whole pictures: tests/passes/pipelines.
#include "framework/core/rng.hpp"
#include "passes/pipelines/adaptive_aa.hpp"
#include "passes/surface/first_sample.hpp"
#include "passes/surface/shade.hpp"
#include "shaders/shared/scene.h"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/scene_bench.hpp"
#include "tests/support/surface_scenes.hpp"

#include <array>
#include <bit>
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

/// Sums by one back end for any map of counts, as bits of the floats; 0 where k = 1.
class BackEndBench {
public:
    BackEndBench(gpu::Device& device, const Scene& scene, std::uint32_t width, std::uint32_t height,
        std::uint32_t m, Dispatch dispatch, std::uint32_t stall = 0)
        : bench_(device, scene, scene.cameras.front(), width, height, m,
              paper_order(static_cast<int>(m))) {
        const ShadingInputs in{.scene = bench_.inputs,
            .gbuffer = add_gbuffer(bench_.graph, bench_.inputs, {width, height, m}, 16384),
            .shadow_map = {}};
        const ShadingParams shading{.width = width, .height = height, .m = m, .stall = stall};
        counts_ = bench_.image("sample_count", VK_FORMAT_R8_UINT, width, height,
            std::vector<std::uint8_t>(std::size_t{width} * height, 1));
        sum_ = add(in, shading,
            {.first_sample = add_first_sample(bench_.graph, in, shading),
                .sample_count = counts_,
                .clusters = {}},
            dispatch);
        bench_.graph.export_resource(sum_, "test");
    }

    std::vector<std::uint32_t> sums(const std::vector<std::uint8_t>& map) {
        bench_.set(counts_, map);
        bench_.execute();
        const std::vector<float> sums = interleaved(bench_.read(sum_));
        std::vector<std::uint32_t> bits(sums.size());
        for (std::size_t i = 0; i < sums.size(); ++i)
            bits[i] = map[i / 4] == 1 ? 0 : std::bit_cast<std::uint32_t>(sums[i]);
        return bits;
    }

private:
    ImageHandle add(const ShadingInputs& in, const ShadingParams& shading,
        const AdaptiveInputs& counts, Dispatch dispatch) {
        Graph& graph = bench_.graph;
        const auto buckets = [&] {
            return add_buckets(
                graph, counts.sample_count, {shading.width, shading.height, shading.m * shading.m});
        };
        switch (dispatch) {
        case Dispatch::loop:
            break;
        case Dispatch::buckets:
            return add_shade_buckets(graph, in, shading, counts, buckets());
        case Dispatch::sort:
            return add_shade_sorted(graph, in, shading, counts, buckets());
        case Dispatch::repack:
            return add_shade_repacked(graph, in, shading, counts,
                add_tile_list(graph, counts.sample_count, shading.width, shading.height));
        case Dispatch::stencil:
            return add_shade_tested(graph, in, shading, counts, CountTest::stencil);
        case Dispatch::depth:
            return add_shade_tested(graph, in, shading, counts, CountTest::depth);
        }
        return add_shade_loop(graph, in, shading, counts);
    }

    SceneBench bench_;
    ImageHandle counts_, sum_;
};

/// Maps that are easy to get wrong: all 1, all n, one pixel n, everything mixed.
std::vector<std::vector<std::uint8_t>> hard_maps(std::size_t pixels, std::uint32_t n) {
    const auto most = static_cast<std::uint8_t>(n);
    std::vector<std::vector<std::uint8_t>> maps(4, std::vector<std::uint8_t>(pixels, 1));
    maps[1].assign(pixels, most);
    maps[2][pixels / 2] = most;
    Pcg32 rng(n);
    for (std::uint8_t& k : maps[3]) k = static_cast<std::uint8_t>(1 + rng.below(n));
    return maps;
}

TEST_F(ShadeTest, AnyMapOfCountsGivesTheSameSumsByEveryBackEnd) {
    const Scene scene = varied_scene();
    struct Case {
        std::uint32_t width, height, m;
    };
    const std::uint32_t widest = std::min(8191u, device().limits().attachment_extent / 2);
    for (const auto& [width, height, m] :
        {Case{19, 13, 4}, {11, 9, 8}, {1, 1, 4}, {7, 5, 3}, {widest, 1, 2}}) {
        const auto maps = hard_maps(std::size_t{width} * height, m * m);
        std::vector<std::vector<std::uint32_t>> expected;
        for (const Dispatch dispatch : kDispatches) {
            if (dispatch == Dispatch::stencil && !device().exports_stencil()) continue;
            SCOPED_TRACE(testing::Message() << width << "x" << height << ", m = " << m
                                            << ", --dispatch " << name_of(dispatch));
            BackEndBench bench(device(), scene, width, height, m, dispatch);
            for (std::size_t i = 0; i < maps.size(); ++i) {
                const auto sums = bench.sums(maps[i]);
                if (dispatch == Dispatch::loop) expected.push_back(sums);
                EXPECT_EQ(sums, expected[i]) << "map " << i;
            }
        }
    }
}

TEST_F(ShadeTest, RoundsContinueTheSameSumsInEveryBackEnd) {
    const Scene scene = varied_scene();
    const auto map = hard_maps(11 * 9, 16).back();
    const auto expected = BackEndBench(device(), scene, 11, 9, 4, Dispatch::loop).sums(map);
    for (const Dispatch dispatch : kDispatches) {
        if (dispatch == Dispatch::stencil && !device().exports_stencil()) continue;
        // 10,000 iterations of stall: four samples fit one kernel.
        BackEndBench bench(device(), scene, 11, 9, 4, dispatch, 16 * 10000);
        EXPECT_EQ(bench.sums(map), expected) << "--dispatch " << name_of(dispatch);
    }
}

/// What picks.glsl picks, as ranks with weights: seats by d'Hondt, the first sample's surface
/// first.
std::vector<std::pair<std::uint32_t, double>> stratified_picks(
    const std::vector<std::uint32_t>& labels, std::uint32_t k) {
    std::array<std::uint32_t, 4> sizes{}, seats{1, 0, 0, 0};
    for (const std::uint32_t label : labels) ++sizes[label];
    const auto claim = [&](std::size_t l) { // unseen surfaces come before all others
        return (seats[l] == 0 ? 1000.0 : 1.0) * sizes[l] / (seats[l] + 1.0);
    };
    for (std::uint32_t i = 1; i < k; ++i) {
        std::size_t best = 0;
        for (std::size_t l = 1; l < 4; ++l)
            if (claim(l) > claim(best) + 1e-9) best = l;
        ++seats[best];
    }
    double seen = 0;
    for (std::size_t l = 0; l < 4; ++l) seen += seats[l] > 0 ? sizes[l] : 0;
    std::array<std::uint32_t, 4> left = seats;
    std::vector<std::pair<std::uint32_t, double>> picks;
    for (std::uint32_t rank = 0; rank < labels.size(); ++rank) {
        const std::uint32_t l = labels[rank];
        if (left[l] == 0) continue;
        --left[l];
        picks.emplace_back(rank, sizes[l] / seen * k / seats[l]);
    }
    return picks;
}

TEST_F(ShadeTest, StratifiedPicksAreSharedOutAmongSurfacesByCoverage) {
    const Scene scene = untextured_scene();
    const LitScene lit(device(), scene);
    constexpr std::uint32_t kWidth = 17, kHeight = 11;
    for (const std::uint32_t m : {2u, 3u, 4u, 8u}) {
        const std::uint32_t n = m * m;
        const Image samples = render(lit, params(m * kWidth, m * kHeight, 1, AaMethod::none));
        const std::vector<std::uint32_t> order = paper_order(static_cast<int>(m));
        Pcg32 rng(m);
        std::vector<std::uint8_t> map(kWidth * kHeight);
        std::vector<std::vector<std::uint32_t>> labels(map.size());
        const std::uint32_t words = n > 16 ? 4 : 1;
        std::vector<std::uint32_t> texels(map.size() * words);
        for (std::size_t p = 0; p < map.size(); ++p) {
            map[p] = static_cast<std::uint8_t>(1 + rng.below(n));
            // Surfaces of any size, numbered as they occur.
            const std::uint32_t surfaces = 1 + rng.below(4);
            std::uint32_t known = 1;
            for (std::uint32_t rank = 0; rank < n; ++rank) {
                std::uint32_t label = rank == 0 || rng.below(2) ? 0 : rng.below(surfaces);
                if (label >= known) label = known++;
                labels[p].push_back(label);
                texels[p * words + rank / 16] |= label << 2 * (rank % 16);
            }
        }
        SceneBench bench(device(), scene, scene.cameras.front(), kWidth, kHeight, m, order);
        const ShadingInputs in{.scene = bench.inputs,
            .gbuffer = add_gbuffer(bench.graph, bench.inputs, {kWidth, kHeight, m}, 16384),
            .shadow_map = {}};
        const ShadingParams shading{.width = kWidth, .height = kHeight, .m = m};
        const AdaptiveInputs counts{.first_sample = add_first_sample(bench.graph, in, shading),
            .sample_count = bench.image("sample_count", VK_FORMAT_R8_UINT, kWidth, kHeight, map),
            .clusters = bench.image("clusters",
                words == 4 ? VK_FORMAT_R32G32B32A32_UINT : VK_FORMAT_R32_UINT, kWidth, kHeight,
                texels)};
        const ImageHandle sum = add_shade_loop(bench.graph, in, shading, counts);
        bench.graph.export_resource(sum, "test");
        bench.execute();
        const Image found = bench.read(sum);
        std::size_t several = 0;
        for (std::size_t p = 0; p < map.size(); ++p) {
            const std::uint32_t k = map[p];
            if (k == 1 || k == n) continue;
            const auto picks = stratified_picks(labels[p], k);
            ASSERT_EQ(picks.size(), k);
            ASSERT_EQ(picks.front().first, 0u) << "S is always taken";
            several += picks[1].second != 1.0;
            const int x = static_cast<int>(p % kWidth), y = static_cast<int>(p / kWidth);
            for (int c = 0; c < 4; ++c) {
                double expected = 0, weights = 0;
                for (const auto& [rank, weight] : picks) {
                    weights += weight;
                    expected +=
                        weight *
                        samples.at(x * static_cast<int>(m) + static_cast<int>(order[rank] % m),
                            y * static_cast<int>(m) + static_cast<int>(order[rank] / m), c);
                }
                ASSERT_NEAR(weights, k, 1e-9);
                ASSERT_NEAR(found.at(x, y, c), expected, 2e-6 * std::max(1.0, expected))
                    << "m = " << m << ", k = " << k << ", pixel " << x << "," << y;
            }
        }
        EXPECT_GT(several, map.size() / 8) << "weights differ";
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

/// `scene` with so many black lights and unused materials before its own.
Scene padded(Scene scene, std::size_t lights, std::size_t materials) {
    scene.materials.insert(scene.materials.begin(), materials, Material{});
    for (Mesh& mesh : scene.meshes) {
        for (Primitive& primitive : mesh.primitives)
            primitive.material += static_cast<int>(materials);
    }
    Light black; // a point light
    black.intensity = glm::vec3(0.0f);
    scene.lights.insert(scene.lights.begin(), lights, black);
    return scene;
}

TEST_F(ShadeTest, LightsAndMaterialsBeyondAUniformBufferChangeNoBit) {
    const Scene scene = varied_scene();
    AdaptiveAaParams p = params(48, 32, 2, AaMethod::adaptive);
    p.resolve = Resolve::stratified;
    p.demodulate = p.filter_highlights = true;
    for (const GbufferLayout layout : {GbufferLayout::packed, GbufferLayout::visibility}) {
        p.gbuffer = layout;
        const LitScene few(device(), scene);
        const std::vector<float> expected = interleaved(render(few, p));
        for (const bool lights : {false, true}) {
            const LitScene many(device(), padded(scene, lights ? FEW_LIGHTS : 0, FEW_MATERIALS));
            EXPECT_EQ(interleaved(render(many, p)), expected) << "lights: " << lights;
        }
    }
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

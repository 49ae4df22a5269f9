// SPDX-License-Identifier: Apache-2.0
// What the pictures of intermediate values show: normal, view depth and material of the first
// sample, and background where nothing was hit.
#include "passes/debug/surface_aov.hpp"
#include "shaders/debug/surface_aov.h"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/scene_bench.hpp"
#include "tests/support/surface_scenes.hpp"

#include <cmath>

namespace ockham::test {
namespace {

class SurfaceAovTest : public GpuTest {};

TEST_F(SurfaceAovTest, ShowsNormalDepthAndMaterialOfTheFirstSample) {
    // The left half of the picture, tilted: 4 deep for every 3 across, its front towards +z.
    Scene scene;
    scene.materials.resize(3);
    add(scene, rectangle({0, 0, 0}, {6, 0, -8}, {0, 8, 0}, 2));
    const std::uint32_t width = 12, height = 8;
    for (const std::uint32_t m : {1u, 2u, 3u}) {
        const std::vector<std::uint32_t> order = paper_order(static_cast<int>(m));
        SceneBench bench(device(), scene, pixel_camera(width, height), width, height, m, order);
        const Gbuffer gbuffer = add_gbuffer(bench.graph, bench.inputs, {width, height, m}, 16384);
        const SurfaceAov aov =
            add_surface_aov(bench.graph, bench.inputs.frame, gbuffer, width, height);
        bench.graph.export_resource(aov.surface, "test");
        bench.graph.export_resource(aov.material, "test");
        bench.execute();
        const Image surface = bench.read(aov.surface), material = bench.read(aov.material);
        const float first = (static_cast<float>(order[0] % m) + 0.5f) / static_cast<float>(m);
        for (int y = 0; y < 8; ++y) {
            for (int x = 0; x < 12; ++x) {
                if (x < 6) {
                    EXPECT_NEAR(surface.at(x, y, 0), 0.8f, 1e-4f);
                    EXPECT_NEAR(surface.at(x, y, 1), 0.0f, 1e-4f);
                    EXPECT_NEAR(surface.at(x, y, 2), 0.6f, 1e-4f);
                    const float across = static_cast<float>(x) + first;
                    EXPECT_NEAR(surface.at(x, y, 3), 100 + 8.0f / 6.0f * across, 1e-3f);
                    EXPECT_EQ(material.at(x, y, 0), 2.0f);
                } else {
                    for (int c = 0; c < 3; ++c) EXPECT_EQ(surface.at(x, y, c), 0.0f);
                    EXPECT_TRUE(std::isinf(surface.at(x, y, 3)));
                    EXPECT_EQ(material.at(x, y, 0), static_cast<float>(NO_MATERIAL));
                }
            }
        }
    }
}

} // namespace
} // namespace ockham::test

// SPDX-License-Identifier: Apache-2.0
// Ends of rays and what is seen there, against the G-buffer's geometry; whole pictures:
// pipelines/surface_volume.
#include "passes/surface/clusters.hpp"
#include "passes/surface/first_sample.hpp"
#include "passes/surface/frame.hpp"
#include "passes/volume/meshes.hpp"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/pass_bench.hpp"
#include "tests/support/surface_scenes.hpp"

#include <gtest/gtest.h>

#include <bit>

namespace ockham::test {
namespace {

class MeshesTest : public GpuTest {};

TEST_F(MeshesTest, WhatIsHiddenIsNotMissedByColoursThatNoRayHasSeen) {
    // Two pixels of 2 x 2 samples; the second sees a black surface and, twice, a bright one.
    const float distance = 3.0f;
    const std::uint32_t zero = std::bit_cast<std::uint32_t>(distance) & ~3u;
    const std::vector<std::uint32_t> ends{zero, zero, zero, zero | 1, zero, zero, zero | 1, zero};
    const std::vector<glm::vec4> picture{glm::vec4(1.0f), glm::vec4(50, 50, 50, 1)};
    for (std::uint32_t count = 1; count <= 9; ++count) {
        // Opaque fog of radiance 0.25 in front of the second pixel, nothing in front of the first.
        const std::uint32_t more = count % 4, bright = 2 * (count / 4) + (more > 1) + (more > 2);
        const float seen = 100.0f * static_cast<float>(bright) / static_cast<float>(count);
        const std::vector<glm::vec4> change{
            glm::vec4(0.0f), {0.25f - seen, 0.25f - seen, 0.25f - seen, 1}};
        PassBench bench(device());
        MeshInputs meshes;
        meshes.ends = bench.image("mesh_ends", VK_FORMAT_R32_UINT, 4, 2, ends);
        meshes.picture = bench.image("meshes", VK_FORMAT_R32G32B32A32_SFLOAT, 2, 1, picture);
        ImageHandle layers = bench.graph.create_image("mesh_radiance",
            {.format = VK_FORMAT_R32G32B32A32_SFLOAT, .width = 2, .height = 1, .layers = 2});
        {
            PassBuilder pass = bench.graph.add_transfer_pass("layers");
            layers = pass.copy_to(layers);
            pass.record([=](Commands& commands) {
                commands.clear(layers.layer(0), {0, 0, 0, 1});
                commands.clear(layers.layer(1), {100, 100, 100, 1});
            });
        }
        meshes.radiance = layers;
        const ImageHandle out = add_over_meshes(bench.graph, meshes,
            bench.image("change", VK_FORMAT_R32G32B32A32_SFLOAT, 2, 1, change),
            {.progress = bench.buffer(
                 "progress", std::vector<glm::uvec2>{{count, count}, {count, count}}),
                .count = {}},
            2);
        bench.graph.export_resource(out, "test");
        bench.execute();
        const Image sum = bench.read(out);
        EXPECT_EQ(sum.plane(0)[0], 1.0f) << count;
        EXPECT_NEAR(sum.plane(0)[1], 0.25f, 2e-5f) << count;
        EXPECT_EQ(sum.plane(3)[1], 1.0f);
    }
}

} // namespace
} // namespace ockham::test

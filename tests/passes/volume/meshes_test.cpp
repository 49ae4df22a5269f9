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

TEST_F(MeshesTest, TheSumIsExactWhereNothingChanges) {
    PassBench bench(device());
    const std::vector<glm::vec4> meshes{{0.1f, 0.2f, 0.3f, 1.0f}, {5, 6, 7, 0}},
        change{{0, 0, 0, 0}, {-1, 0.5f, 0, 0.25f}};
    const ImageHandle out = add_over_meshes(bench.graph,
        bench.image("meshes", VK_FORMAT_R32G32B32A32_SFLOAT, 2, 1, meshes),
        bench.image("change", VK_FORMAT_R32G32B32A32_SFLOAT, 2, 1, change));
    bench.graph.export_resource(out, "test");
    bench.execute();
    const Image sum = bench.read(out);
    const float expected[4][2] = {{0.1f, 4}, {0.2f, 6.5f}, {0.3f, 7}, {1, 0.25f}};
    for (int c = 0; c < 4; ++c)
        for (std::size_t i = 0; i < 2; ++i) EXPECT_EQ(sum.plane(c)[i], expected[c][i]);
}

} // namespace
} // namespace ockham::test

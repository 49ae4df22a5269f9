// SPDX-License-Identifier: Apache-2.0
// Counts by the number of surfaces, on label images made by hand.
#include "passes/surface/cluster_counts.hpp"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/pass_bench.hpp"

#include <glm/glm.hpp>

namespace ockham::test {
namespace {

class ClusterCountsTest : public GpuTest {
protected:
    template <class Texel>
    static std::vector<float> counts(
        VkFormat format, const std::vector<Texel>& labels, const ClusterCountsParams& params) {
        PassBench bench(device());
        const auto width = static_cast<std::uint32_t>(labels.size());
        const ImageHandle out = add_cluster_counts(
            bench.graph, bench.image("clusters", format, width, 1, labels), params, "test");
        bench.graph.export_resource(out, "test");
        bench.execute();
        return interleaved(bench.read(out));
    }
};

using Counts = std::vector<float>;

TEST_F(ClusterCountsTest, SmallWindowsHoldTheirLabelsInOneWord) {
    // n = 4: all 0; 0 0 0 1; 0 1 2 2; 0 1 2 3.
    const std::vector<std::uint32_t> labels{0x00, 0x40, 0xa4, 0xe4};
    const auto of = [&](std::uint32_t single, std::uint32_t several) {
        return counts(VK_FORMAT_R32_UINT, labels, {4, single, several});
    };
    EXPECT_EQ(of(1, 0), (Counts{1, 2, 3, 4})) << "one for each surface";
    EXPECT_EQ(of(1, 4), (Counts{1, 4, 4, 4})) << "all on edges";
    EXPECT_EQ(of(3, 3), (Counts{3, 3, 3, 3})) << "the same everywhere";
}

TEST_F(ClusterCountsTest, LargeWindowsHoldTheirsInFour) {
    // n = 64: all 0; the last sample 1; label 2 in the second word, 1 before; all four.
    const std::vector<glm::uvec4> labels{
        {0, 0, 0, 0}, {0, 0, 0, 0x40000000}, {4, 0x80, 0, 0}, {4, 0x80, 0xc, 0}};
    EXPECT_EQ(counts(VK_FORMAT_R32G32B32A32_UINT, labels, {64, 1, 0}), (Counts{1, 2, 3, 4}));
    EXPECT_EQ(counts(VK_FORMAT_R32G32B32A32_UINT, labels, {64, 1, 64}), (Counts{1, 64, 64, 64}));
}

} // namespace
} // namespace ockham::test

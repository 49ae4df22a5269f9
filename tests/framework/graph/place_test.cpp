// SPDX-License-Identifier: Apache-2.0
#include "framework/core/error.hpp"
#include "framework/graph/compile/pack.hpp"
#include "tests/framework/graph/plan_lines.hpp"

#include <gtest/gtest.h>

namespace ockham {
namespace {

void expect_disjoint(const std::vector<LiveRange>& ranges, const Packing& packing) {
    ASSERT_EQ(packing.offsets.size(), ranges.size());
    for (std::size_t i = 0; i < ranges.size(); ++i) {
        EXPECT_EQ(packing.offsets[i] % ranges[i].alignment, 0u);
        EXPECT_LE(packing.offsets[i] + ranges[i].bytes, packing.bytes);
        for (std::size_t k = 0; k < i; ++k) {
            const bool share_step =
                ranges[i].first <= ranges[k].last && ranges[k].first <= ranges[i].last;
            const bool share_byte = packing.offsets[i] < packing.offsets[k] + ranges[k].bytes &&
                                    packing.offsets[k] < packing.offsets[i] + ranges[i].bytes;
            EXPECT_FALSE(share_step && share_byte) << i << " and " << k;
        }
    }
}

TEST(Pack, NothingAndOne) {
    EXPECT_EQ(pack({}).bytes, 0u);
    EXPECT_EQ(live_bytes({}), 0u);
    const std::vector<LiveRange> one{{100, 256, 3, 9}};
    EXPECT_EQ(pack(one).bytes, 100u);
    EXPECT_EQ(live_bytes(one), 100u);
}

TEST(Pack, ChainOfTwoAliveNeedsTheTwoLargestNeighbours) {
    const std::vector<LiveRange> chain{{64, 1, 0, 1}, {32, 1, 1, 2}, {64, 1, 2, 3}, {16, 1, 3, 4}};
    EXPECT_EQ(live_bytes(chain), 96u);
    const Packing packing = pack(chain);
    expect_disjoint(chain, packing);
    EXPECT_EQ(packing.bytes, 96u);
}

TEST(Pack, BeatsTheSweepWhereOrderMatters) {
    // A sweep puts the long small range above the first, where it splits the room of the last.
    const std::vector<LiveRange> ranges{{4, 1, 0, 0}, {1, 1, 0, 2}, {5, 1, 1, 1}, {5, 1, 2, 2}};
    const Packing packing = pack(ranges);
    expect_disjoint(ranges, packing);
    EXPECT_EQ(packing.bytes, live_bytes(ranges));
}

TEST(Pack, ManyAliveAtOnceFallBackToOneSweep) {
    std::vector<LiveRange> ranges; // each dies 2000 steps after it starts: pairs exceed the limit
    for (std::uint32_t i = 0; i < 3000; ++i) ranges.push_back({1 + i % 7, 4, i, i + 2000});
    expect_disjoint(ranges, pack(ranges));
}

TEST(Place, EstimateCountsMipsLayersAndAlignment) {
    ResourceDecl image;
    image.kind = ResourceKind::image;
    image.image = {VK_FORMAT_R16G16B16A16_SFLOAT, 5, 3, 1, 2, 3};
    // (5x3 + 2x1 + 1x1) texels x 2 layers x 8 bytes = 288
    EXPECT_EQ(estimate_memory(image).bytes, 512u);
    ResourceDecl buffer;
    buffer.buffer.bytes = 1;
    EXPECT_EQ(estimate_memory(buffer).bytes, 256u);
    EXPECT_EQ(estimate_memory(buffer).alignment, 256u);
}

TEST(Place, TexelBytes) {
    EXPECT_EQ(texel_bytes(VK_FORMAT_UNDEFINED), 0u);
    EXPECT_EQ(texel_bytes(VK_FORMAT_BC1_RGB_UNORM_BLOCK), 0u);
    const std::pair<VkFormat, std::uint32_t> table[] = {{VK_FORMAT_R8_UNORM, 1},
        {VK_FORMAT_R8_UINT, 1}, {VK_FORMAT_R8G8_UNORM, 2}, {VK_FORMAT_R8G8B8A8_UNORM, 4},
        {VK_FORMAT_R8G8B8A8_SRGB, 4}, {VK_FORMAT_R16_UNORM, 2}, {VK_FORMAT_R16_SFLOAT, 2},
        {VK_FORMAT_R16G16_SFLOAT, 4}, {VK_FORMAT_R16G16_SNORM, 4},
        {VK_FORMAT_R16G16B16A16_UNORM, 8}, {VK_FORMAT_R16G16B16A16_SFLOAT, 8},
        {VK_FORMAT_R32_SFLOAT, 4}, {VK_FORMAT_R32_UINT, 4}, {VK_FORMAT_R32G32_SFLOAT, 8},
        {VK_FORMAT_R32G32_UINT, 8}, {VK_FORMAT_R32G32B32A32_SFLOAT, 16},
        {VK_FORMAT_R32G32B32A32_UINT, 16}, {VK_FORMAT_B10G11R11_UFLOAT_PACK32, 4},
        {VK_FORMAT_A2B10G10R10_UNORM_PACK32, 4}, {VK_FORMAT_B8G8R8A8_UNORM, 4},
        {VK_FORMAT_E5B9G9R9_UFLOAT_PACK32, 4}, {VK_FORMAT_D32_SFLOAT, 4}};
    for (const auto& [format, bytes] : table) EXPECT_EQ(texel_bytes(format), bytes) << format;
}

/// in -> a -> b -> c -> out, `count` buffers of 1024 bytes between two that are exported.
Graph chain(std::uint32_t count) {
    Graph graph("chain");
    BufferHandle previous = graph.create_persistent_buffer("in", {1024});
    for (std::uint32_t i = 0; i < count; ++i) {
        BufferHandle next = graph.create_buffer(fmt::format("b{}", i), {1024});
        auto pass = graph.add_compute_pass(fmt::format("p{}", i));
        pass.read("from", previous);
        previous = pass.write("to", next);
    }
    graph.export_resource(previous, "end of the chain");
    return graph;
}

TEST(Place, AChainNeedsTwo) {
    const Graph graph = chain(10);
    const Plan plan = compile(graph.declaration());
    // Two of the chain at a time, the persistent and the exported one.
    EXPECT_EQ(plan.bytes_peak, 4 * 1024u);
    EXPECT_EQ(plan.bytes_lower_bound, 4 * 1024u);
    ASSERT_EQ(plan.heaps.size(), 3u);
    EXPECT_TRUE(plan.heaps[0].shared);
    EXPECT_FALSE(plan.heaps[1].shared);
    EXPECT_FALSE(plan.heaps[2].shared);
}

TEST(Place, PolicyTurnsSharingOff) {
    const Graph graph = chain(10);
    Policy policy;
    policy.alias_memory = false;
    const Plan plan = compile(graph.declaration(), {}, policy);
    EXPECT_EQ(plan.bytes_peak, 11 * 1024u);
    EXPECT_EQ(plan.bytes_lower_bound, 4 * 1024u);
}

TEST(Place, MemoryTypesDoNotMix) {
    Graph graph = chain(10);
    for (std::size_t i = 0; i < graph.declaration().resources.size(); ++i)
        graph.declaration().resources[i].memory = {1024, 64, i % 2 ? 1u : 2u};
    const Plan plan = compile(graph.declaration());
    for (const Placement& placement : plan.placements)
        EXPECT_EQ(plan.heaps[placement.heap].type_bits, placement.resource % 2 ? 1u : 2u);
    EXPECT_EQ(plan.heaps.size(), 4u);
}

TEST(Place, OffsetsKeepAlignmentAndGranularity) {
    Graph graph = chain(10);
    for (std::size_t i = 0; i < graph.declaration().resources.size(); ++i)
        graph.declaration().resources[i].memory = {1000 + i, 48, 1};
    for (const Placement& placement : compile(graph.declaration()).placements)
        EXPECT_EQ(placement.offset % 48, 0u);
    for (ResourceDecl& resource : graph.declaration().resources) resource.memory.alignment = 64;
    Capabilities capabilities;
    capabilities.buffer_image_granularity = 4096;
    const Plan plan = compile(graph.declaration(), capabilities);
    for (const Placement& placement : plan.placements) EXPECT_EQ(placement.offset % 4096, 0u);
    EXPECT_EQ(plan.heaps[0].bytes, 2 * 4096u);
}

TEST(Place, BudgetErrorNamesTheLargest) {
    Graph graph("g");
    BufferHandle small = graph.create_buffer("small", {1 << 20});
    BufferHandle large = graph.create_buffer("large", {3 << 20});
    auto p = graph.add_compute_pass("p");
    small = p.write("small", small);
    auto q = graph.add_compute_pass("q");
    q.read("small", small);
    large = q.write("large", large);
    graph.export_resource(large, "the picture");
    Policy policy;
    policy.memory_budget_bytes = 4 << 20;
    EXPECT_EQ(compile(graph.declaration(), {}, policy).bytes_peak, 4u << 20);
    policy.memory_budget_bytes -= 1;
    try {
        (void)compile(graph.declaration(), {}, policy);
        FAIL() << "a plan above the budget was accepted";
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::device);
        EXPECT_STREQ(error.what(),
            "[over-budget] graph 'g' does not fit into 4.000 MiB; shrink, split or raise them\n"
            "graph 'g' needs 4.000 MiB for 2 resources, in this order of passes at least 4.000 "
            "MiB; the largest:\n"
            "       3.000 MiB  large                    kept: used by 'q'; exported (the picture)\n"
            "       1.000 MiB  small                    kept: used from 'p' to 'q'");
    }
}

} // namespace
} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/graph.hpp"
#include "tests/framework/graph/plan_lines.hpp"

#include <gtest/gtest.h>

namespace ockham {
namespace {

TEST(Graph, WritingReturnsTheNextVersion) {
    Graph graph("g");
    const BufferHandle first = graph.create_buffer("data", {64});
    auto fill = graph.add_transfer_pass("fill");
    const BufferHandle second = fill.copy_to(first);
    auto add = graph.add_compute_pass("add");
    const BufferHandle third = add.read_write("data", second);
    EXPECT_EQ(first.version, 0u);
    EXPECT_EQ(second.version, 1u);
    EXPECT_EQ(third.version, 2u);
    EXPECT_EQ(third.resource, first.resource);
    EXPECT_TRUE(graph.declaration().misuses.empty());
    const Use& use = graph.declaration().uses[1];
    EXPECT_EQ(use.version, 1u);
    EXPECT_EQ(use.version_written, 2u);
}

TEST(Graph, FindReturnsTheNewestVersion) {
    Graph graph("g");
    const ImageHandle color = graph.create_image("color", kColor);
    auto pass = graph.add_compute_pass("pass");
    const ImageHandle written = pass.write("color", color);
    EXPECT_EQ(graph.find_image("color").version, written.version);
    EXPECT_EQ(graph.find_image("color").resource, written.resource);
    EXPECT_FALSE(graph.find_image("colour"));
    EXPECT_FALSE(graph.find_buffer("color")); // an image is not found as a buffer
    EXPECT_EQ(graph.desc(color).width, 64u);
}

TEST(Graph, PassRemembersWhatItWasTold) {
    Graph graph("g");
    graph.add_compute_pass("first");
    auto pass = graph.add_compute_pass("second");
    pass.because("it is nice").side_effect("prints").record([](Commands&) {});
    const PassDecl& decl = graph.declaration().passes[1];
    EXPECT_EQ(decl.reason, "it is nice");
    EXPECT_EQ(decl.side_effect, "prints");
    EXPECT_FALSE(graph.recorder(0));
    EXPECT_TRUE(graph.recorder(1));
}

TEST(Graph, AttachmentsKeepLoadAndClear) {
    Graph graph("g");
    const ImageHandle color = graph.create_image("color", kColor);
    const ImageHandle depth = graph.create_image("depth", kDepth);
    auto pass = graph.add_raster_pass("draw");
    (void)pass.color(color, LoadOp::clear, {1, 2, 3, 4});
    (void)pass.depth(depth, 0.5f);
    const auto& uses = graph.declaration().uses;
    EXPECT_EQ(uses[0].load, LoadOp::clear);
    EXPECT_EQ(graph.declaration().details[0].clear[3], 4.0f);
    EXPECT_EQ(uses[1].load, LoadOp::clear);
    EXPECT_EQ(graph.declaration().details[1].clear[0], 0.5f);
    EXPECT_FALSE(needs_content(uses[1]));
    EXPECT_TRUE(replaces_content(uses[1]));
}

TEST(Graph, NothingCompilesToNothing) {
    const Plan plan = compile(Graph("empty").declaration());
    EXPECT_TRUE(plan.steps.empty());
    EXPECT_TRUE(plan.barriers.empty());
    EXPECT_TRUE(plan.heaps.empty());
    EXPECT_EQ(plan.bytes_peak, 0u);
    EXPECT_EQ(plan.bytes_lower_bound, 0u);
    EXPECT_EQ(plan.batches(), 0u);
    EXPECT_EQ(compile(Declaration{}).steps.size(), 0u);
}

TEST(Graph, OnePass) {
    Graph graph("one");
    BufferHandle out = graph.create_buffer("out", {1000});
    auto pass = graph.add_compute_pass("pass");
    out = pass.write("out", out);
    graph.export_resource(out, "the result");
    const Plan plan = compile(graph.declaration());
    ASSERT_EQ(plan.steps.size(), 1u);
    EXPECT_EQ(plan.batches(), 1u);
    EXPECT_EQ(plan.bytes_peak, 1024u);
    EXPECT_EQ(plan.bytes_lower_bound, 1024u);
    // The previous execution wrote it too; nothing else is to be waited for.
    EXPECT_EQ(barrier_lines(graph.declaration(), plan),
        "pass <- (before): out first_use | compute/storage_write -> compute/storage_write\n");
}

} // namespace
} // namespace ockham

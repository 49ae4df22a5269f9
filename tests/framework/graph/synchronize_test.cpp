// SPDX-License-Identifier: Apache-2.0
// Every kind of barrier, as lines of text; access_test ties the words to Vulkan's bits.
#include "tests/framework/graph/plan_lines.hpp"

#include <gtest/gtest.h>

namespace ockham {
namespace {

constexpr AccessState kUntouched{};

/// A resource whose barriers are not disturbed by how its memory was used before.
BufferHandle fresh_buffer(Graph& graph, const char* name, std::uint64_t bytes = 64) {
    return graph.import_buffer(name, {bytes}, kUntouched);
}
ImageHandle fresh_image(Graph& graph, const char* name, ImageDesc desc = kColor) {
    return graph.import_image(name, desc, kUntouched);
}

TEST(Synchronize, WriteThenRead) {
    Graph graph("g");
    BufferHandle a = fresh_buffer(graph, "a");
    auto w = graph.add_compute_pass("w");
    a = w.write("a", a);
    auto r = graph.add_compute_pass("r");
    r.read("a", a).side_effect("test");
    EXPECT_EQ(barrier_lines(graph),
        "r <- w: a read_after_write | compute/storage_write -> compute/storage_read\n");
}

TEST(Synchronize, ReadsInOneStageShareABarrier) {
    Graph graph("g");
    BufferHandle a = fresh_buffer(graph, "a");
    auto w = graph.add_compute_pass("w");
    a = w.write("a", a);
    auto r1 = graph.add_compute_pass("r1");
    r1.read("a", a).side_effect("test");
    auto r2 = graph.add_compute_pass("r2");
    r2.read("a", a).side_effect("test");
    EXPECT_EQ(barrier_lines(graph),
        "r1 <- w: a read_after_write | compute/storage_write -> compute/storage_read\n");
}

TEST(Synchronize, AReadInANewStageExtendsTheBarrierAndAWriteWaitsForAll) {
    Graph graph("g");
    BufferHandle a = fresh_buffer(graph, "a");
    auto w = graph.add_compute_pass("w");
    a = w.write("a", a);
    auto r1 = graph.add_compute_pass("r1");
    r1.read("a", a).side_effect("test");
    auto r2 = graph.add_compute_pass("r2");
    r2.indirect(a).side_effect("test");
    auto w2 = graph.add_transfer_pass("w2");
    a = w2.copy_to(a);
    EXPECT_EQ(barrier_lines(graph),
        "r1 <- w: a read_after_write | compute/storage_write -> "
        "indirect+compute/indirect_read+storage_read\n"
        "w2 <- r2: a write_after_read | compute/none -> transfer/none\n");
}

TEST(Synchronize, WriteAfterWrite) {
    Graph graph("g");
    BufferHandle a = fresh_buffer(graph, "a");
    auto w = graph.add_transfer_pass("w");
    a = w.copy_to(a);
    auto w2 = graph.add_transfer_pass("w2");
    a = w2.copy_to(a);
    EXPECT_EQ(barrier_lines(graph),
        "w2 <- w: a write_after_write | transfer/transfer_write -> transfer/transfer_write\n");
}

TEST(Synchronize, ReadWriteAfterReadWrite) {
    Graph graph("g");
    ImageHandle a = graph.import_image(
        "a", kColor, {VK_PIPELINE_STAGE_2_NONE, VK_ACCESS_2_NONE, VK_IMAGE_LAYOUT_GENERAL});
    auto w = graph.add_compute_pass("w");
    a = w.read_write("a", a);
    auto w2 = graph.add_compute_pass("w2");
    a = w2.read_write("a", a);
    EXPECT_EQ(barrier_lines(graph),
        "w2 <- w: a read_after_write | compute/storage_write -> compute/storage_read+storage_write "
        "| general -> general\n");
}

TEST(Synchronize, LayoutsFollowTheAccess) {
    Graph graph("g");
    ImageHandle a = fresh_image(graph, "a");
    auto draw = graph.add_raster_pass("draw");
    a = draw.color(a);
    auto sample = graph.add_compute_pass("sample");
    sample.sample("a", a).side_effect("test");
    auto load = graph.add_compute_pass("load");
    load.read("a", a).side_effect("test");
    auto copy = graph.add_transfer_pass("copy");
    copy.copy_from(a).side_effect("test");
    auto store = graph.add_compute_pass("store");
    a = store.read_write("a", a);
    EXPECT_EQ(barrier_lines(graph),
        "draw <- (before): a first_use | none/none -> color_output/color_read+color_write | "
        "undefined -> color\n"
        "sample <- draw: a read_after_write | color_output/color_write -> compute/sampled_read | "
        "color -> read_only\n"
        "load <- sample: a layout | compute/none -> compute/storage_read | read_only -> general\n"
        "copy <- load: a layout | compute/none -> transfer/transfer_read | general -> "
        "transfer_src\n"
        "store <- copy: a write_after_read | transfer/none -> compute/storage_read+storage_write | "
        "transfer_src -> general\n");
}

TEST(Synchronize, AReplacedImageNeedNotSurviveItsTransition) {
    Graph graph("g");
    ImageHandle a = graph.import_image("a", kColor,
        {VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT,
            VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL});
    auto store = graph.add_compute_pass("store");
    a = store.write("a", a);
    EXPECT_EQ(barrier_lines(graph),
        "store <- (before): a write_after_read | compute/none -> compute/storage_write | undefined "
        "-> general\n");
}

TEST(Synchronize, DepthIsTestedInTwoStagesThenSampled) {
    Graph graph("g");
    ImageHandle z = fresh_image(graph, "z", kDepth);
    auto draw = graph.add_raster_pass("draw");
    z = draw.depth(z, 0);
    auto sample = graph.add_compute_pass("sample");
    sample.sample("z", z).side_effect("test");
    Graph& g = graph;
    EXPECT_EQ(barrier_lines(g),
        "draw <- (before): z first_use | none/none -> depth_tests/depth_read+depth_write | "
        "undefined -> depth\n"
        "sample <- draw: z read_after_write | depth_tests/depth_write -> compute/sampled_read | "
        "depth -> read_only\n");
}

TEST(Synchronize, VerticesIndicesAndUniforms) {
    Graph graph("g");
    BufferHandle v = fresh_buffer(graph, "v"), i = fresh_buffer(graph, "i"),
                 u = fresh_buffer(graph, "u");
    ImageHandle target = fresh_image(graph, "target");
    auto upload = graph.add_transfer_pass("upload");
    v = upload.copy_to(v);
    i = upload.copy_to(i);
    u = upload.copy_to(u);
    auto draw = graph.add_raster_pass("draw");
    draw.vertices(v).indices(i).uniform("u", u, Stage::vertex);
    target = draw.color(target);
    EXPECT_EQ(barrier_lines(graph),
        "draw <- upload: v read_after_write | transfer/transfer_write -> vertex_input/vertex_read\n"
        "draw <- upload: i read_after_write | transfer/transfer_write -> index_input/index_read\n"
        "draw <- upload: u read_after_write | transfer/transfer_write -> vertex/uniform_read\n"
        "draw <- (before): target first_use | none/none -> color_output/color_read+color_write | "
        "undefined -> color\n");
}

TEST(Synchronize, OneBatchBeforeEachStep) {
    Graph graph("g");
    BufferHandle a = fresh_buffer(graph, "a"), b = fresh_buffer(graph, "b");
    auto w = graph.add_compute_pass("w");
    a = w.write("a", a);
    b = w.write("b", b);
    auto r = graph.add_compute_pass("r");
    r.read("a", a).read("b", b).side_effect("test");
    const Plan plan = compile(graph.declaration());
    EXPECT_EQ(plan.batches(), 1u);
    EXPECT_EQ(plan.steps[0].barrier_count, 0u);
    EXPECT_EQ(plan.steps[1].first_barrier, 0u);
    EXPECT_EQ(plan.steps[1].barrier_count, 2u);
    EXPECT_EQ(plan.exit_barrier_count, 0u);
}

/// a is written and read, then b, then c; a and c share memory, and so do the executions.
TEST(Synchronize, AliasesHandMemoryOverAndTheFirstWaitsForThePreviousExecution) {
    Graph graph("g");
    BufferHandle a = graph.create_buffer("a", {256}), b = graph.create_buffer("b", {256}),
                 c = graph.create_buffer("c", {256}), out = graph.create_buffer("out", {4});
    auto p0 = graph.add_compute_pass("p0");
    a = p0.write("a", a);
    auto p1 = graph.add_compute_pass("p1");
    p1.read("a", a);
    b = p1.write("b", b);
    auto p2 = graph.add_transfer_pass("p2");
    p2.copy_from(b);
    c = p2.copy_to(c);
    auto p3 = graph.add_compute_pass("p3");
    p3.read("c", c);
    out = p3.write("out", out);
    graph.export_resource(out, "test");
    const Plan plan = compile(graph.declaration());
    EXPECT_EQ(plan.bytes_peak, 3 * 256u);
    EXPECT_EQ(plan.bytes_peak, plan.bytes_lower_bound);
    EXPECT_EQ(plan.placements[0].offset, plan.placements[2].offset); // a and c
    EXPECT_EQ(barrier_lines(graph.declaration(), plan),
        "p0 <- (before): a alias | compute/none -> compute/none\n"
        "p1 <- p0: a read_after_write | compute/storage_write -> compute/storage_read\n"
        "p2 <- p1: b read_after_write | compute/storage_write -> transfer/transfer_read\n"
        "p3 <- p2: c read_after_write | transfer/transfer_write -> compute/storage_read\n"
        "p3 <- (before): out first_use | compute/storage_write -> compute/storage_write\n");
}

TEST(Synchronize, WithoutAliasingEveryResourceWaitsForItselfOnly) {
    Graph graph("g");
    ImageHandle a = graph.create_image("a", kColor), b = graph.create_image("b", kColor);
    auto p0 = graph.add_raster_pass("p0");
    a = p0.color(a);
    p0.side_effect("test");
    auto p1 = graph.add_compute_pass("p1");
    b = p1.write("b", b);
    p1.side_effect("test");
    Policy policy;
    policy.alias_memory = false;
    const Plan plan = compile(graph.declaration(), {}, policy);
    EXPECT_EQ(plan.bytes_peak, 2 * 64u * 64 * 4);
    EXPECT_EQ(barrier_lines(graph.declaration(), plan),
        "p0 <- (before): a first_use | color_output/color_write -> "
        "color_output/color_read+color_write | undefined -> color\n"
        "p1 <- (before): b first_use | compute/storage_write -> compute/storage_write | undefined "
        "-> general\n");
}

TEST(Synchronize, AnUnreadWriteIsMadeAvailableToTheNextOwner) {
    Graph graph("g");
    ImageHandle color = graph.create_image("color", kColor), z = graph.create_image("z", kDepth),
                next = graph.create_image("next", kColor);
    auto draw = graph.add_raster_pass("draw");
    z = draw.depth(z, 0);
    draw.side_effect("test");
    auto store = graph.add_compute_pass("store");
    next = store.write("next", next);
    store.side_effect("test");
    (void)color;
    EXPECT_EQ(barrier_lines(graph),
        "draw <- (before): z alias | compute/storage_write -> depth_tests/depth_read+depth_write | "
        "undefined -> depth\n"
        "store <- draw: next alias | depth_tests/depth_write -> compute/storage_write | undefined "
        "-> general\n");
}

TEST(Synchronize, PersistentResourcesEnterAsThePreviousExecutionLeftThem) {
    Graph graph("g");
    ImageHandle history = graph.create_persistent_image("history", kColor);
    auto read = graph.add_compute_pass("read");
    read.sample("history", history).side_effect("test");
    auto update = graph.add_compute_pass("update");
    history = update.read_write("history", history);
    const Plan plan = compile(graph.declaration());
    EXPECT_EQ(plan.final_states[0], state_of(Access::storage_read_write, Stage::compute));
    EXPECT_EQ(barrier_lines(graph.declaration(), plan),
        "read <- (before): history read_after_write | compute/storage_write -> "
        "compute/sampled_read | general -> read_only\n"
        "update <- read: history write_after_read | compute/none -> "
        "compute/storage_read+storage_write | read_only -> general\n");
    EXPECT_EQ(
        plan.usages[0], VkFlags{VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_STORAGE_BIT |
                                VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT});
}

TEST(Synchronize, APersistentTableThatIsOnlyReadNeedsNoBarrier) {
    Graph graph("g");
    const BufferHandle table = graph.create_persistent_buffer("table", {64});
    auto read = graph.add_compute_pass("read");
    read.read("table", table).side_effect("test");
    auto again = graph.add_compute_pass("again");
    again.uniform("table", table).side_effect("test");
    const Plan plan = compile(graph.declaration());
    EXPECT_EQ(barrier_lines(graph.declaration(), plan), "");
    EXPECT_EQ(plan.final_states[0].access,
        VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_UNIFORM_READ_BIT);
}

/// The write of one execution is read at the end of it in one stage, and at the start of the next
/// in another, which must wait for it too.
TEST(Synchronize, AReadInANewStageAcrossExecutionsWaits) {
    Graph graph("g");
    BufferHandle count = graph.create_persistent_buffer("count", {12});
    auto dispatch = graph.add_compute_pass("dispatch");
    dispatch.indirect(count).side_effect("test");
    auto write = graph.add_compute_pass("write");
    count = write.write("count", count);
    auto read = graph.add_compute_pass("read");
    read.read("count", count).side_effect("test");
    EXPECT_EQ(barrier_lines(graph),
        "dispatch <- (before): count read_after_write | compute/storage_write -> "
        "indirect/indirect_read\n"
        "write <- dispatch: count write_after_read | indirect/none -> compute/none\n"
        "read <- write: count read_after_write | compute/storage_write -> compute/storage_read\n");
}

TEST(Synchronize, ExternalResourcesComeAndGoInThePromisedStates) {
    Graph graph("g");
    const AccessState drawn{VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
        VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
    const AccessState presented{
        VK_PIPELINE_STAGE_2_NONE, VK_ACCESS_2_NONE, VK_IMAGE_LAYOUT_PRESENT_SRC_KHR};
    const ImageHandle in = graph.import_image("in", kColor, drawn);
    ImageHandle out = graph.import_image("out", kColor, kUntouched, presented);
    BufferHandle stats =
        graph.import_buffer("stats", {64}, kUntouched, state_of(Access::host_read, Stage::fixed));
    auto pass = graph.add_compute_pass("pass");
    pass.sample("in", in);
    out = pass.write("out", out);
    stats = pass.write("stats", stats);
    const Plan plan = compile(graph.declaration());
    EXPECT_EQ(barrier_lines(graph.declaration(), plan),
        "pass <- (before): in read_after_write | color_output/color_write -> compute/sampled_read "
        "| color -> read_only\n"
        "pass <- (before): out first_use | none/none -> compute/storage_write | undefined -> "
        "general\n"
        "(after) <- pass: out exit | compute/storage_write -> none/none | general -> present\n"
        "(after) <- pass: stats exit | compute/storage_write -> host/host_read\n");
    EXPECT_EQ(plan.first_exit_barrier, 2u);
    EXPECT_EQ(plan.exit_barrier_count, 2u);
    EXPECT_EQ(plan.batches(), 2u);
    EXPECT_TRUE(plan.placements.empty());
    EXPECT_EQ(plan.final_states[in.resource], state_of(Access::sampled, Stage::compute));
    EXPECT_EQ(plan.final_states[out.resource], presented);
}

TEST(Synchronize, AnExitThatHoldsAlreadyNeedsNoBarrier) {
    Graph graph("g");
    const AccessState sampled = state_of(Access::sampled, Stage::compute);
    const ImageHandle in = graph.import_image("in", kColor, sampled, sampled);
    auto pass = graph.add_compute_pass("pass");
    pass.sample("in", in).side_effect("test");
    EXPECT_EQ(barrier_lines(graph), "");
}

TEST(Synchronize, MipsAreSynchronizedByThemselvesAndTogether) {
    Graph graph("g");
    ImageHandle a = fresh_image(graph, "a", {VK_FORMAT_R32_SFLOAT, 64, 64, 1, 1, 3});
    auto top = graph.add_compute_pass("top");
    a = top.write("to", a.mip(0));
    auto half = graph.add_compute_pass("half");
    half.sample("from", a.mip(0));
    a = half.write("to", a.mip(1));
    auto quarter = graph.add_compute_pass("quarter");
    quarter.sample("from", a.mip(1));
    a = quarter.write("to", a.mip(2));
    auto look = graph.add_raster_pass("look");
    ImageHandle target = fresh_image(graph, "target");
    look.sample("a", a, Stage::fragment);
    target = look.color(target);
    EXPECT_EQ(barrier_lines(graph),
        "top <- (before): a first_use | none/none -> compute/storage_write | undefined -> general\n"
        "half <- top: a read_after_write | compute/storage_write -> fragment+compute/sampled_read "
        "| "
        "general -> read_only\n"
        "half <- (before): a first_use | none/none -> compute/storage_write | undefined -> "
        "general\n"
        "quarter <- half: a read_after_write | compute/storage_write -> "
        "fragment+compute/sampled_read | general -> read_only\n"
        "quarter <- (before): a first_use | none/none -> compute/storage_write | undefined -> "
        "general\n"
        "look <- quarter: a read_after_write | compute/storage_write -> fragment/sampled_read | "
        "general -> read_only\n"
        "look <- (before): target first_use | none/none -> color_output/color_read+color_write | "
        "undefined -> color\n");
}

TEST(Synchronize, NeighbouringRangesShareABarrier) {
    Graph graph("g");
    BufferHandle a = fresh_buffer(graph, "a", 1024);
    auto first = graph.add_compute_pass("first");
    a = first.write("a", a.range(0, 256));
    auto second = graph.add_compute_pass("second");
    a = second.write("a", a.range(256, 256));
    auto read = graph.add_compute_pass("read");
    read.read("a", a.range(0, 512)).side_effect("test");
    const Plan plan = compile(graph.declaration());
    EXPECT_EQ(barrier_lines(graph.declaration(), plan),
        "read <- second: a read_after_write | compute/storage_write -> compute/storage_read\n");
    ASSERT_EQ(plan.barriers.size(), 1u);
    EXPECT_EQ(plan.barriers[0].part.offset, 0u);
    EXPECT_EQ(plan.barriers[0].part.bytes, 512u);
}

/// w2 and w3 may only begin when r has read a and b; one of the two barriers says so for both.
TEST(Synchronize, WhatAnotherBarrierImpliesIsLeftOut) {
    Graph graph("g");
    BufferHandle a = fresh_buffer(graph, "a"), b = fresh_buffer(graph, "b");
    auto w = graph.add_compute_pass("w");
    a = w.write("a", a);
    b = w.write("b", b);
    auto r = graph.add_compute_pass("r");
    r.read("a", a).read("b", b).side_effect("test");
    auto w2 = graph.add_compute_pass("w2");
    a = w2.write("a", a);
    auto w3 = graph.add_compute_pass("w3");
    b = w3.write("b", b);
    EXPECT_EQ(barrier_lines(graph),
        "r <- w: a read_after_write | compute/storage_write -> compute/storage_read\n"
        "r <- w: b read_after_write | compute/storage_write -> compute/storage_read\n"
        "w2 <- r: a write_after_read | compute/none -> compute/none\n");
}

/// The present content is written in one execution and sampled in the next, where it is one older.
TEST(Synchronize, AgesOfAHistoryEnterAsTheYoungerOneWasLeft) {
    Graph graph("g");
    const auto history = graph.create_history_image("h", kColor, 1);
    ImageHandle out = fresh_image(graph, "out");
    auto blend = graph.add_compute_pass("blend");
    blend.sample("old", history.previous[0]);
    (void)blend.write("new", history.now);
    out = blend.write("out", out);
    const Plan plan = compile(graph.declaration());
    EXPECT_EQ(barrier_lines(graph.declaration(), plan),
        "blend <- (before): h@-1 read_after_write | compute/storage_write -> compute/sampled_read "
        "| general -> read_only\n"
        "blend <- (before): h write_after_read | compute/none -> compute/storage_write | undefined "
        "-> general\n"
        "blend <- (before): out first_use | none/none -> compute/storage_write | undefined -> "
        "general\n");
    EXPECT_EQ(plan.final_states[0], state_of(Access::storage_write, Stage::compute));
    EXPECT_EQ(plan.final_states[1], state_of(Access::sampled, Stage::compute));
    EXPECT_EQ(plan.usages[0], plan.usages[1]);
}

TEST(Synchronize, AWriteThatMayNotHappenKeepsTheContent) {
    Graph graph("g");
    const Condition odd = graph.add_condition("odd");
    ImageHandle a = fresh_image(graph, "a");
    auto w = graph.add_compute_pass("w");
    a = w.write("a", a);
    auto look = graph.add_compute_pass("look");
    look.sample("a", a).side_effect("test");
    {
        const auto only = graph.when(odd);
        auto again = graph.add_compute_pass("again");
        a = again.write("a", a);
    }
    auto last = graph.add_compute_pass("last");
    last.sample("a", a).side_effect("test");
    EXPECT_EQ(barrier_lines(graph),
        "w <- (before): a first_use | none/none -> compute/storage_write | undefined -> general\n"
        "look <- w: a read_after_write | compute/storage_write -> compute/sampled_read | general "
        "-> read_only\n"
        "again <- look: a write_after_read | compute/none -> compute/storage_write | read_only -> "
        "general\n"
        "last <- again: a read_after_write | compute/storage_write -> compute/sampled_read | "
        "general -> read_only\n");
}

TEST(Synchronize, PartsOfAKeptImageAreLeftInOneLayout) {
    Graph graph("g");
    ImageHandle a = graph.create_persistent_image("a", {VK_FORMAT_R32_SFLOAT, 64, 64, 1, 1, 3});
    auto pass = graph.add_compute_pass("pass");
    pass.sample("from", a.mips(0, 2));
    a = pass.write("to", a.mip(2));
    const Plan plan = compile(graph.declaration());
    EXPECT_EQ(barrier_lines(graph.declaration(), plan),
        "pass <- (before): a write_after_read | compute/none -> compute/storage_write | undefined "
        "-> general\n"
        "(after) <- pass: a exit | compute/storage_write -> compute/sampled_read | general -> "
        "read_only\n");
    EXPECT_EQ(plan.exit_barrier_count, 1u);
}

/// Family 1 does compute only.
Capabilities two_families() {
    Capabilities capabilities;
    capabilities.families = {{true, true, true, 1}, {false, true, true, 1}};
    return capabilities;
}

TEST(Synchronize, ContentMovesBetweenQueueFamiliesByReleaseAndAcquire) {
    Graph graph("g");
    BufferHandle a = graph.create_buffer("a", {256}), b = graph.create_buffer("b", {256});
    auto w = graph.add_compute_pass("w");
    a = w.write("a", a);
    auto side = graph.add_compute_pass("side");
    side.prefer(QueueWish::async_compute).read("a", a);
    b = side.write("b", b);
    auto busy = graph.add_compute_pass("busy");
    busy.side_effect("test");
    auto join = graph.add_compute_pass("join");
    join.read("b", b).side_effect("test");
    const Plan plan = compile(graph.declaration(), two_families());
    ASSERT_EQ(plan.queues.size(), 2u);
    EXPECT_EQ(barrier_lines(graph.declaration(), plan),
        "side <- w: a release | compute/storage_write -> none/none\n"
        "side <- w: a acquire | compute/none -> compute/storage_read\n"
        "join <- side: b release | compute/storage_write -> none/none\n"
        "join <- side: b acquire | compute/none -> compute/storage_read\n");
    EXPECT_EQ(plan.steps[0].release_count, 1u);
    EXPECT_EQ(plan.barriers_before(plan.steps[1]).back().dst_family, 1u);
}

TEST(Synchronize, KeptResourcesOfSeveralFamiliesNeverMove) {
    Graph graph("g");
    BufferHandle a = graph.create_persistent_buffer("a", {256}),
                 b = graph.create_buffer("b", {256});
    auto w = graph.add_compute_pass("w");
    a = w.read_write("a", a);
    auto side = graph.add_compute_pass("side");
    side.prefer(QueueWish::async_compute).read("a", a);
    b = side.write("b", b);
    auto busy = graph.add_compute_pass("busy");
    busy.side_effect("test");
    auto join = graph.add_compute_pass("join");
    join.read("b", b).side_effect("test");
    const Plan plan = compile(graph.declaration(), two_families());
    EXPECT_EQ(plan.concurrent[0], 1);
    EXPECT_EQ(barrier_lines(graph.declaration(), plan), // a's reader waits by semaphore
        "join <- side: b release | compute/storage_write -> none/none\n"
        "join <- side: b acquire | compute/none -> compute/storage_read\n");
}

TEST(Synchronize, TheCallersFamilyHandsOverAndGetsBack) {
    Graph graph("g");
    AccessState entry = state_of(Access::transfer_write, Stage::fixed);
    AccessState exit = state_of(Access::transfer_read, Stage::fixed);
    entry.queue_family = exit.queue_family = 2;
    ImageHandle a = graph.import_image("a", kColor, entry, exit);
    auto pass = graph.add_compute_pass("pass");
    a = pass.read_write("a", a);
    Capabilities capabilities = two_families();
    capabilities.families.push_back({false, false, true, 1});
    const Plan plan = compile(graph.declaration(), capabilities);
    EXPECT_EQ(barrier_lines(graph.declaration(), plan),
        "pass <- (before): a acquire | compute/none -> compute/storage_read+storage_write | "
        "transfer_dst -> general\n"
        "(after) <- pass: a release | compute/storage_write -> none/none | general -> "
        "transfer_src\n");
    EXPECT_EQ(plan.barriers[0].src_family, 2u);
    EXPECT_EQ(plan.exit_barriers()[0].dst_family, 2u);
}

} // namespace
} // namespace ockham

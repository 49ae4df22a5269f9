// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/explain/explain.hpp"
#include "tests/framework/graph/plan_lines.hpp"

#include <gtest/gtest.h>

namespace ockham {
namespace {

std::string verdict(const Graph& graph, const Plan& plan, const std::string& name) {
    const Declaration& declaration = graph.declaration();
    for (std::size_t i = 0; i < declaration.passes.size(); ++i)
        if (declaration.passes[i].name == name)
            return reason_of_pass(declaration, plan, static_cast<PassId>(i));
    for (std::size_t i = 0; i < declaration.resources.size(); ++i)
        if (declaration.resources[i].name == name)
            return reason_of_resource(declaration, plan, static_cast<ResourceId>(i));
    return "no such name";
}

TEST(Cull, KeepsWhatAnExportNeedsInProgramOrder) {
    Graph graph("g");
    BufferHandle a = graph.create_buffer("a", {4}), b = graph.create_buffer("b", {4}),
                 unread = graph.create_buffer("unread", {4});
    auto first = graph.add_compute_pass("first");
    a = first.write("a", a);
    auto debug = graph.add_compute_pass("debug");
    debug.read("a", a);
    unread = debug.write("unread", unread);
    auto second = graph.add_compute_pass("second");
    second.read("a", a).because("the user asked for it");
    b = second.write("b", b);
    graph.export_resource(b, "the picture");
    const Plan plan = compile(graph.declaration());
    EXPECT_EQ(order_line(graph.declaration(), plan), "first second");
    EXPECT_EQ(verdict(graph, plan, "first"), "kept: 'second' reads its 'a'");
    EXPECT_EQ(verdict(graph, plan, "debug"), "culled: nothing reads 'unread'");
    EXPECT_EQ(verdict(graph, plan, "second"),
        "kept: exported 'b' needs it (the picture); the user asked for it");
    EXPECT_EQ(verdict(graph, plan, "a"), "kept: used from 'first' to 'second'");
    EXPECT_EQ(verdict(graph, plan, "b"), "kept: used by 'second'; exported (the picture)");
    EXPECT_EQ(verdict(graph, plan, "unread"), "culled: no live pass uses it");
}

TEST(Cull, ChainsOfUnreadPassesGoTogether) {
    Graph graph("g");
    BufferHandle a = graph.create_buffer("a", {4}), b = graph.create_buffer("b", {4}),
                 c = graph.create_buffer("c", {4});
    auto first = graph.add_compute_pass("first");
    a = first.write("a", a);
    auto second = graph.add_compute_pass("second");
    second.read("a", a);
    b = second.write("b", b);
    c = second.write("c", c);
    auto third = graph.add_compute_pass("third");
    third.read("b", b);
    const Plan plan = compile(graph.declaration());
    EXPECT_TRUE(plan.steps.empty());
    EXPECT_EQ(verdict(graph, plan, "first"), "culled: only 'second', culled too, reads 'a'");
    EXPECT_EQ(verdict(graph, plan, "second"),
        "culled: only 'third', culled too, reads 'b', nothing reads 'c'");
    EXPECT_EQ(verdict(graph, plan, "third"), "culled: it writes nothing");
    EXPECT_EQ(plan.bytes_peak, 0u);
}

TEST(Cull, AWriteMakesEarlierProducersUnneeded) {
    Graph graph("g");
    BufferHandle a = graph.create_buffer("a", {4});
    auto first = graph.add_compute_pass("first");
    a = first.write("a", a);
    auto second = graph.add_compute_pass("second");
    a = second.write("a", a);
    graph.export_resource(a, "x");
    const Plan plan = compile(graph.declaration());
    EXPECT_EQ(order_line(graph.declaration(), plan), "second");
    EXPECT_EQ(
        verdict(graph, plan, "first"), "culled: 'second' replaces 'a' before anything reads it");
}

TEST(Cull, AWriteKeepsProducersWhoseVersionIsRead) {
    Graph graph("g");
    BufferHandle a = graph.create_buffer("a", {4}), b = graph.create_buffer("b", {4});
    auto first = graph.add_compute_pass("first");
    a = first.write("a", a);
    auto copy = graph.add_transfer_pass("copy");
    copy.copy_from(a);
    b = copy.copy_to(b);
    auto second = graph.add_compute_pass("second");
    a = second.write("a", a);
    graph.export_resource(a, "x");
    graph.export_resource(b, "y");
    EXPECT_EQ(order_line(graph.declaration(), compile(graph.declaration())), "first copy second");
}

TEST(Cull, ReadWriteAndCopiesKeepProducers) {
    Graph graph("g");
    BufferHandle a = graph.create_buffer("a", {4});
    auto first = graph.add_compute_pass("first");
    a = first.write("a", a);
    auto part = graph.add_transfer_pass("part"); // may cover a part only
    a = part.copy_to(a);
    auto second = graph.add_compute_pass("second");
    a = second.read_write("a", a);
    graph.export_resource(a, "x");
    EXPECT_EQ(order_line(graph.declaration(), compile(graph.declaration())), "first part second");
}

TEST(Cull, LoadedAttachmentsKeepProducersClearedOnesDoNot) {
    for (const LoadOp load : {LoadOp::discard, LoadOp::clear, LoadOp::load}) {
        Graph graph("g");
        ImageHandle a = graph.create_image("a", kColor);
        auto first = graph.add_compute_pass("first");
        a = first.write("a", a);
        auto draw = graph.add_raster_pass("draw");
        a = draw.color(a, load);
        graph.export_resource(a, "x");
        EXPECT_EQ(order_line(graph.declaration(), compile(graph.declaration())),
            load == LoadOp::load ? "first draw" : "draw");
    }
}

TEST(Cull, SideEffectsPersistentAndExternalKeepPasses) {
    Graph graph("g");
    BufferHandle history = graph.create_persistent_buffer("history", {4});
    BufferHandle target = graph.import_buffer("target", {4}, {});
    auto effect = graph.add_compute_pass("effect");
    effect.side_effect("counts runs");
    auto update = graph.add_compute_pass("update");
    history = update.read_write("history", history);
    auto deliver = graph.add_compute_pass("deliver");
    target = deliver.write("target", target);
    auto look = graph.add_compute_pass("look");
    look.read("history", history);
    const Plan plan = compile(graph.declaration());
    EXPECT_EQ(order_line(graph.declaration(), plan), "effect update deliver");
    EXPECT_EQ(verdict(graph, plan, "effect"), "kept: side effect (counts runs)");
    EXPECT_EQ(verdict(graph, plan, "update"),
        "kept: persistent 'history' carries it to the next execution");
    EXPECT_EQ(verdict(graph, plan, "deliver"), "kept: external 'target' hands it to the caller");
    EXPECT_EQ(verdict(graph, plan, "history"), "kept: used by 'update'; persistent");
    EXPECT_EQ(verdict(graph, plan, "target"), "kept: used by 'deliver'; external");
}

TEST(Cull, AnEarlierWriteToAPersistentResourceIsUnneededToo) {
    Graph graph("g");
    BufferHandle history = graph.create_persistent_buffer("history", {4});
    auto first = graph.add_compute_pass("first");
    history = first.write("history", history);
    auto second = graph.add_compute_pass("second");
    history = second.write("history", history);
    EXPECT_EQ(order_line(graph.declaration(), compile(graph.declaration())), "second");
}

TEST(Cull, UnusedResourcesTakeNoMemory) {
    Graph graph("g");
    (void)graph.create_persistent_buffer("unused", {1 << 20});
    const Plan plan = compile(graph.declaration());
    EXPECT_TRUE(plan.placements.empty());
    EXPECT_TRUE(plan.resources[0].culled);
}

/// Replacing one mip leaves the writer of the others alive.
TEST(Cull, PartsAreJudgedOneByOne) {
    Graph graph("g");
    ImageHandle a = graph.create_image("a", {VK_FORMAT_R8_UNORM, 8, 8, 1, 1, 2});
    auto both = graph.add_compute_pass("both");
    a = both.write("a", a);
    auto top = graph.add_compute_pass("top");
    a = top.write("a", a.mip(0));
    auto low = graph.add_compute_pass("low");
    a = low.write("a", a.mip(1));
    graph.export_resource(a, "the picture");
    const Plan plan = compile(graph.declaration());
    EXPECT_EQ(order_line(graph.declaration(), plan), "top low");
    EXPECT_EQ(verdict(graph, plan, "top"), "kept: exported 'a' needs it (the picture)");

    Graph second("g");
    a = second.create_image("a", {VK_FORMAT_R8_UNORM, 8, 8, 1, 1, 2});
    auto all = second.add_compute_pass("both");
    a = all.write("a", a);
    auto one = second.add_compute_pass("top");
    a = one.write("a", a.mip(0));
    second.export_resource(a, "the picture");
    EXPECT_EQ(order_line(second.declaration(), compile(second.declaration())), "both top");
}

/// A pass that may not run replaces nothing.
TEST(Cull, GuardedWritesKeepWhatTheyMightReplace) {
    Graph graph("g");
    BufferHandle a = graph.create_buffer("a", {4});
    auto first = graph.add_compute_pass("first");
    a = first.write("a", a);
    {
        const auto guard = graph.when(graph.add_condition("again"));
        auto second = graph.add_compute_pass("second");
        a = second.write("a", a);
    }
    graph.export_resource(a, "the result");
    EXPECT_EQ(order_line(graph.declaration(), compile(graph.declaration())), "first second");
}

TEST(Cull, HistoriesLiveWhereAnOlderContentIsRead) {
    const auto make = [](std::uint32_t age, bool exported) {
        Graph graph("g");
        auto history = graph.create_history_buffer("h", {4}, 2);
        auto pass = graph.add_compute_pass("next");
        if (age) pass.read("old", history.previous[age - 1]);
        history.now = pass.write("new", history.now);
        auto look = graph.add_compute_pass("look");
        look.read("h", history.now);
        BufferHandle out = look.write("out", graph.create_buffer("out", {4}));
        if (exported) graph.export_resource(out, "the result");
        return graph;
    };
    Graph graph = make(2, true);
    Plan plan = compile(graph.declaration());
    EXPECT_EQ(order_line(graph.declaration(), plan), "next look");
    EXPECT_EQ(verdict(graph, plan, "h@-2"), "kept: used by 'next'; 2 executions old");
    EXPECT_EQ(verdict(graph, plan, "h@-1"),
        "kept: a step of the history between two that are used; 1 execution old");

    // Nobody reads an older content: the ring does not turn.
    graph = make(0, true);
    plan = compile(graph.declaration());
    EXPECT_EQ(order_line(graph.declaration(), plan), "next look");
    EXPECT_EQ(
        verdict(graph, plan, "h"), "kept: used from 'next' to 'look'; newest of 3 kept contents");
    EXPECT_EQ(verdict(graph, plan, "h@-1"), "culled: no live pass uses it");

    // A ring that feeds only itself is dead.
    graph = make(1, false);
    plan = compile(graph.declaration());
    EXPECT_TRUE(plan.steps.empty());
    EXPECT_EQ(verdict(graph, plan, "next"), "culled: only 'look', culled too, reads 'h'");
}

/// What is added onto keeps all ages: it comes back when the ring has turned once.
TEST(Cull, AccumulatingIntoAHistoryReadsItsOldestContent) {
    Graph graph("g");
    auto history = graph.create_history_buffer("h", {4}, 1);
    auto pass = graph.add_compute_pass("add");
    history.now = pass.read_write("h", history.now);
    graph.export_resource(history.now, "the sum");
    const Plan plan = compile(graph.declaration());
    EXPECT_EQ(order_line(graph.declaration(), plan), "add");
    EXPECT_FALSE(plan.resources[history.previous[0].resource].culled);
}

TEST(Cull, PassesThatNoAnswersLetRunAreCulled) {
    Graph graph("g");
    const Condition foggy = graph.add_condition("foggy");
    BufferHandle a = graph.create_persistent_buffer("a", {4});
    const auto outer = graph.unless(foggy);
    auto clear = graph.add_compute_pass("clear");
    a = clear.read_write("a", a);
    const auto inner = graph.when(foggy);
    auto never = graph.add_compute_pass("never");
    a = never.read_write("a", a);
    const Plan plan = compile(graph.declaration());
    EXPECT_EQ(order_line(graph.declaration(), plan), "clear");
    EXPECT_EQ(verdict(graph, plan, "never"),
        "culled: its conditions contradict each other; unless 'foggy' and where 'foggy'");
}

} // namespace
} // namespace ockham

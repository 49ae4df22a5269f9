// SPDX-License-Identifier: Apache-2.0
// What a plan says of itself: each kind of reason once, word for word.
#include "framework/graph/explain/explain.hpp"
#include "framework/graph/explain/timeline.hpp"
#include "tests/framework/graph/plan_lines.hpp"
#include "tests/framework/graph/random_graph.hpp"
#include "tests/framework/graph/two_queues.hpp"

#include <gtest/gtest.h>

#include <map>

namespace ockham {
namespace {

/// "after <- before" of every direct dependency, a line for each pair of passes.
std::string order_lines(const Declaration& declaration, const Plan& plan) {
    const std::vector<Dependency> direct = direct_dependencies(declaration, plan);
    std::string text;
    for (PassId pass = 0; pass < declaration.passes.size(); ++pass)
        for (const auto& pair : dependencies_of(direct, pass))
            text += reason_of_order(declaration, pair) + "\n";
    return text;
}
std::string order_lines(const Graph& graph) {
    return order_lines(graph.declaration(), compile(graph.declaration()));
}

/// The sentence of the first barrier of that hazard; empty where there is none.
std::string barrier_reason(const Declaration& declaration, const Plan& plan, Hazard hazard) {
    const auto found = std::ranges::find(plan.barriers, hazard, &Barrier::hazard);
    return found == plan.barriers.end() ? "" : reason_of_barrier(declaration, plan, *found);
}

TEST(Explain, OrderNamesOnlyDirectReasons) {
    Graph graph("g");
    BufferHandle a = graph.create_buffer("a", {64}), b = graph.create_buffer("b", {64}),
                 c = graph.create_buffer("c", {64});
    auto first = graph.add_compute_pass("first");
    a = first.write("a", a);
    b = first.write("b", b);
    auto second = graph.add_compute_pass("second");
    second.read("a", a).read("b", b);
    c = second.write("c", c);
    auto third = graph.add_compute_pass("third"); // 'a' of first too, but second is between
    third.read("c", c).read("a", a).side_effect("it counts");
    auto fourth = graph.add_compute_pass("fourth");
    a = fourth.write("a", a);
    graph.export_resource(a, "wanted");
    EXPECT_EQ(order_lines(graph), "'first' writes 'a' and 'b' for 'second' to read\n"
                                  "'second' writes 'c' for 'third' to read\n"
                                  "'third' reads 'a' before 'fourth' changes it\n");
}

TEST(Explain, OrderNamesParts) {
    Graph graph("g");
    ImageHandle pyramid = graph.create_image(
        "pyramid", {.format = VK_FORMAT_R32_SFLOAT, .width = 64, .height = 64, .mips = 3});
    BufferHandle sum = graph.create_buffer("sum", {1024});
    auto base = graph.add_compute_pass("base");
    pyramid = base.write("mip", pyramid.mip(0));
    auto other = graph.add_compute_pass("other"); // of no concern to the next
    pyramid = other.write("mip", pyramid.mip(2));
    auto down = graph.add_compute_pass("down");
    down.sample("from", pyramid.mip(0));
    sum = down.write("sum", sum.range(256, 512));
    graph.export_resource(sum, "wanted");
    Plan plan;
    plan.passes.resize(3);
    EXPECT_EQ(order_lines(graph.declaration(), plan),
        "'base' writes mip 0 of 'pyramid' for 'down' to read\n");
    const Barrier barrier{.resource = sum.resource,
        .part = {.offset = 256, .bytes = 512},
        .hazard = Hazard::write_after_write,
        .from = 0,
        .to = 2};
    EXPECT_EQ(reason_of_barrier(graph.declaration(), plan, barrier),
        "'down' overwrites bytes 256-767 of 'sum', which 'base' wrote");
}

/// Reachability, by definition: every conflict of two kept passes is a path of direct dependencies,
/// and none of these is a path of others.
TEST(Explain, OrderIsTheTransitiveReduction) {
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
        RandomGraph random(seed, 30);
        const Declaration& declaration = random.graph().declaration();
        const Plan plan = compile(declaration);
        const std::size_t count = declaration.passes.size();
        std::vector<std::vector<char>> conflict(count, std::vector<char>(count, 0)),
            path = conflict;
        for (PassId p = 0; p < count; ++p)
            for (PassId q = p + 1; q < count; ++q)
                for (const Use& a : declaration.uses_of(p))
                    for (const Use& b : declaration.uses_of(q))
                        conflict[p][q] |= a.resource == b.resource && !plan.passes[p].culled &&
                                          !plan.passes[q].culled &&
                                          (writes(a.access) || writes(b.access));
        const std::vector<Dependency> direct = direct_dependencies(declaration, plan);
        for (const Dependency& one : direct) path[one.before][one.after] = 1;
        const auto step = path; // single dependencies
        for (PassId k = 0; k < count; ++k)
            for (PassId p = 0; p < count; ++p)
                for (PassId q = 0; q < count; ++q) path[p][q] |= path[p][k] && path[k][q];
        for (PassId p = 0; p < count; ++p)
            for (PassId q = 0; q < count; ++q) {
                EXPECT_TRUE(path[p][q] || !conflict[p][q]) << seed << ": " << p << " " << q;
                if (!step[p][q]) continue;
                EXPECT_TRUE(conflict[p][q]) << seed << ": " << p << " " << q;
                for (PassId k = p + 1; k < q; ++k)
                    EXPECT_FALSE(path[p][k] && path[k][q]) << seed << ": " << p << " " << q;
            }
    }
}

TEST(Explain, GuardsAreNamed) {
    Graph graph("g");
    BufferHandle state = graph.create_persistent_buffer("state", {64});
    const Condition media = graph.add_condition("has_media"), debug = graph.add_condition("debug");
    {
        const GuardScope outer = graph.when(media);
        const GuardScope inner = graph.unless(debug);
        auto march = graph.add_compute_pass("march");
        state = march.read_write("state", state);
        march.because("there is smoke");
    }
    Plan plan;
    plan.passes = {{.cause = Verdict::Cause::persistent, .resource = state.resource}};
    EXPECT_EQ(reason_of_pass(graph.declaration(), plan, 0),
        "kept: persistent 'state' carries it to the next execution; only where 'has_media' and "
        "unless 'debug'; there is smoke");
}

TEST(Explain, HistoriesTellTheirAge) {
    Graph graph("g");
    const auto history = graph.create_history_image("color", kColor, 2);
    Plan plan;
    plan.resources.assign(3, {.cause = Verdict::Cause::used, .pass = 0, .last_pass = 0});
    graph.add_compute_pass("taa");
    const auto reason = [&](ImageHandle image) {
        return reason_of_resource(graph.declaration(), plan, image.resource);
    };
    EXPECT_EQ(reason(history.now), "kept: used by 'taa'; newest of 3 kept contents");
    EXPECT_EQ(reason(history.previous[0]), "kept: used by 'taa'; 1 execution old");
    EXPECT_EQ(reason(history.previous[1]), "kept: used by 'taa'; 2 executions old");
}

TEST(Explain, QueuesAndOwners) {
    const auto [graph, plan] = two_queues();
    EXPECT_EQ(explain(graph.declaration(), plan),
        R"(graph 'two queues': 4 of 4 passes, 7 barriers in 4 batches, 4 submissions to 2 queues, 48.0 KiB (lower bound 48.0 KiB, ratio 1.000)

submission 0, the main queue:
step 0: 'draw' is kept: 'light' reads its 'color'
    first_use: 'draw' begins 'color' anew
    release afterwards: 'draw' gives 'color' up from queue family 0 to queue family 1, for 'light'
submission 1, queue 1:
    waits for the main queue: 'draw' writes 'color' for 'light' to read
step 1: 'light' is kept: 'compose' reads its 'lit'
    after: 'draw' writes 'color' for 'light' to read
    acquire: 'light' takes 'color' over in queue family 1 from queue family 0, where 'draw' had it
    first_use: 'light' begins 'lit' anew
submission 2, the main queue:
step 2: 'shade' is kept: 'compose' reads its 'z'
    first_use: 'shade' begins 'z' anew
submission 3, the main queue:
    waits for queue 1: 'light' writes 'lit' for 'compose' to read
step 3: 'compose' is kept: exported 'lit' needs it (the picture)
    after: 'shade' writes 'z' for 'compose' to read
    after: 'light' writes 'lit' for 'compose' to read
    read_after_write: 'compose' reads 'z' as 'shade' left it
    read_after_write: 'compose' reads 'lit' as 'light' left it

image 'color', 16.0 KiB: kept: used from 'draw' to 'light'
image 'lit', 16.0 KiB: kept: used from 'light' to 'compose'; exported (the picture); memory of its own; used by several queue families at once
image 'z', 16.0 KiB: kept: used from 'shade' to 'compose'

memory: most lives in step 0 ('draw'), 32.0 KiB: 'color' and 'lit'
    'lit' is exported: its content is wanted after the execution
    'color' and 'z' are used on different queues, which may run at the same time
)");
}

TEST(Explain, TheFirstWaitOfALaterReason) {
    auto [graph, plan] = two_queues();
    // The same wait, taken by 'shade' already: its queue-mate 'compose' is who needs it.
    plan.submissions[2] = {0, 2, 1, 1, 1};
    plan.submissions[3] = {0, 3, 1, 2, 0};
    EXPECT_EQ(
        reason_of_wait(graph.declaration(), plan, direct_dependencies(graph.declaration(), plan),
            plan.submissions[2], plan.waits[1]),
        "for queue 1: 'light' writes 'lit' for 'compose' to read");
}

/// 'a' lives in steps 0-1, 'b' in 1-2, 'c' in 2-3: a and c share.
Graph chain() {
    Graph graph("chain");
    BufferHandle a = graph.create_buffer("a", {4096}), b = graph.create_buffer("b", {1024}),
                 c = graph.create_buffer("c", {4096}), out = graph.create_buffer("out", {64}),
                 unread = graph.create_buffer("unread", {64});
    const BufferHandle in = graph.import_buffer("in", {64}, {});
    auto one = graph.add_compute_pass("one");
    one.read("in", in);
    a = one.write("a", a);
    auto two = graph.add_compute_pass("two");
    two.read("a", a);
    b = two.write("b", b);
    auto three = graph.add_compute_pass("three");
    three.read("b", b);
    c = three.write("c", c);
    unread = three.write("unread", unread);
    auto four = graph.add_compute_pass("four");
    four.read("c", c);
    out = four.write("out", out);
    graph.export_resource(out, "wanted");
    return graph;
}

TEST(Explain, WhyMemoryIsNotShared) {
    const Graph graph = chain();
    const Declaration& declaration = graph.declaration();
    Plan plan = compile(declaration);
    const auto why = [&](const char* x, const char* y) {
        return why_not_shared(
            declaration, plan, graph.find_buffer(x).resource, graph.find_buffer(y).resource);
    };
    EXPECT_EQ(why("a", "c"), "'a' and 'c' share 4.0 KiB at offset 0 of heap 0");
    EXPECT_EQ(why("a", "b"), "'a' and 'b' both live in step 1 ('two')");
    EXPECT_EQ(why("b", "out"), "'out' is exported: its content is wanted after the execution");
    EXPECT_EQ(why("in", "a"), "'in' lives in the caller's memory");
    EXPECT_EQ(why("a", "a"), "'a' is one resource");
    EXPECT_EQ(barrier_reason(declaration, plan, Hazard::alias),
        "'one' begins 'a' in memory that the previous execution used last, as 'c'");

    plan = compile(declaration, {}, {.alias_memory = false});
    EXPECT_EQ(why("a", "c"), "'a' and 'c' never live together, but lie apart: sharing was switched "
                             "off or would save nothing");
    plan.queues.push_back({1, 0});
    plan.submissions = {{1, 0, 2, 0, 0}, {0, 2, 2, 0, 0}};
    EXPECT_EQ(
        why("a", "c"), "'a' and 'c' are used on different queues, which may run at the same time");
    plan.heaps.push_back({2, 4096, true});
    for (Placement& one : plan.placements)
        if (declaration.resources[one.resource].name == "c") one.heap = 2;
    EXPECT_EQ(why("a", "c"), "'a' and 'c' need different types of memory (0xffffffff and 0x2)");
}

TEST(Explain, MemoryPeak) {
    const Graph graph = chain();
    const Plan plan = compile(graph.declaration());
    const Peak peak = memory_peak(plan);
    EXPECT_EQ(peak.step, 2u); // b, c, unread, out; at step 1 there is no unread
    EXPECT_EQ(peak.bytes, 4096u + 1024 + 256 + 256);
    EXPECT_EQ(peak.live.front(), graph.find_buffer("c").resource);
    EXPECT_EQ(memory_peak(Plan{}).live.size(), 0u);
}

TEST(Timeline, QueuesRunSideBySide) {
    const auto [graph, plan] = two_queues();
    EXPECT_EQ(start_times(plan, std::vector<double>{2, 5, 1, 1}),
        (std::vector<double>{0, 2, 2, 7})); // shade beside light, compose after both
    EXPECT_EQ(queue_of_steps(plan), (std::vector<std::uint32_t>{0, 1, 0, 0}));
    EXPECT_EQ(submission_of(plan, 0, 2), 2u);
    EXPECT_EQ(submission_of(plan, 1, 2), kNone);
}

} // namespace
} // namespace ockham

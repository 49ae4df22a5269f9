// SPDX-License-Identifier: Apache-2.0
// Graphs declared anew: equal ones replace recording functions and nothing else, others keep what
// is persistent.
#include "framework/core/timer.hpp"
#include "framework/gpu/memory.hpp"
#include "framework/gpu/pipeline.hpp"
#include "framework/graph/plan_cache.hpp"
#include "framework/runtime/executor.hpp"
#include "tests/framework/runtime/small_passes.hpp"
#include "tests/support/gpu_fixture.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace ockham {
namespace {

using test::add_mark;
using test::add_one;
using test::error_of;
using test::read_as;

class UpdateTest : public test::GpuTest {};

struct Frame {
    Graph graph{"frame"};
    BufferHandle marks, next;
    History<BufferHandle> history;
    ImageHandle picture;
};

/// `passes` chained buffers behind a persistent sum, a history and a persistent picture.
Frame frame(std::uint32_t value, int passes, float cleared = 1) {
    Frame f;
    f.marks = add_mark(f.graph, "mark", f.graph.create_persistent_buffer("marks", {256}), value);
    f.history = f.graph.create_history_buffer("x", {256}, 2);
    PassBuilder recur = f.graph.add_compute_pass("recur");
    recur.read("newest", f.history.previous[0]);
    recur.read("oldest", f.history.previous[1]);
    f.history.now = recur.write("target", f.history.now);
    recur.record([value](Commands& commands) {
        commands.dispatch({.shader = "test/recur.comp", .push = as_push(value)}, {1, 1, 1});
    });
    f.next = f.marks;
    for (int i = 0; i < passes; ++i) {
        const std::string name = fmt::format("b{}", i);
        f.next = add_one(f.graph, "to_" + name, f.next, f.graph.create_buffer(name, {256}));
    }
    PassBuilder draw = f.graph.add_raster_pass("draw");
    f.picture = draw.color(
        f.graph.create_image("picture", {.format = VK_FORMAT_R32_SFLOAT, .width = 4, .height = 4}),
        LoadOp::clear, {cleared, 0, 0, 0});
    f.graph.export_resource(f.picture, "checked");
    f.graph.export_resource(f.marks, "checked");
    f.graph.export_resource(f.next, "checked");
    f.graph.export_resource(f.history.now, "checked");
    return f;
}

TEST_F(UpdateTest, AnEqualGraphReplacesRecordingFunctionsOnly) {
    Frame first = frame(1, 20);
    Executor executor(device(), std::move(first.graph));
    executor.execute();
    const Plan* const plan = &executor.plan();
    const std::uint64_t bytes = device().allocator().bytes_used();
    const std::size_t pipelines = device().pipelines().count();
    Frame second = frame(10, 20, 7);
    const Timer timer;
    EXPECT_TRUE(executor.update(std::move(second.graph)));
    const double us_per_pass = 1e6 * timer.seconds() / static_cast<double>(plan->steps.size());
    RecordProperty("update_us_per_pass", fmt::format("{:.3f}", us_per_pass));
    EXPECT_EQ(&executor.plan(), plan);
    EXPECT_EQ(device().allocator().bytes_used(), bytes);
    executor.execute();
    EXPECT_EQ(device().pipelines().count(), pipelines);
    EXPECT_EQ(read_as<std::uint32_t>(executor, first.marks)[0], 11u);
    EXPECT_EQ(read_as<std::uint32_t>(executor, first.next)[0], 31u);
    EXPECT_EQ(executor.read(first.picture).at(3, 3, 0), 7.0f);
}

TEST_F(UpdateTest, AnotherGraphKeepsWhatIsPersistent) {
    Frame first = frame(1, 2);
    Executor executor(device(), std::move(first.graph));
    executor.execute(); // x = 1
    executor.execute(); // x = 1 + 0 + 1 = 2
    Frame second = frame(1, 3);
    const BufferHandle before = second.history.previous[0];
    EXPECT_FALSE(executor.update(std::move(second.graph)));
    executor.execute(); // x = 2 + 1 + 1 = 4
    EXPECT_EQ(read_as<std::uint32_t>(executor, second.marks)[63], 3u);
    EXPECT_EQ(read_as<std::uint32_t>(executor, second.next)[63], 6u);
    EXPECT_EQ(read_as<std::uint32_t>(executor, second.history.now)[0], 4u);
    EXPECT_EQ(read_as<std::uint32_t>(executor, before)[0], 2u);
}

TEST_F(UpdateTest, PlansAreKept) {
    PlanCache plans;
    Frame first = frame(1, 2);
    Executor executor(device(), std::move(first.graph), Policy{}, {.plans = &plans});
    executor.execute();
    for (int turn = 0; turn < 4; ++turn) { // to and fro between two graphs
        Frame next = frame(1, turn % 2 ? 2 : 3);
        EXPECT_FALSE(executor.update(std::move(next.graph)));
        executor.execute();
        const auto marks = static_cast<std::uint32_t>(turn + 2);
        EXPECT_EQ(read_as<std::uint32_t>(executor, next.marks)[0], marks);
        EXPECT_EQ(read_as<std::uint32_t>(executor, next.next)[0], marks + (turn % 2 ? 2 : 3));
    }
    EXPECT_EQ(plans.size(), 2u);
}

TEST_F(UpdateTest, AnotherDescriptionStartsFromZero) {
    const auto declare = [](std::uint64_t bytes) {
        Graph graph("sized");
        const BufferHandle marks =
            add_mark(graph, "mark", graph.create_persistent_buffer("marks", {bytes}), 4);
        graph.export_resource(marks, "checked");
        return std::pair(std::move(graph), marks);
    };
    auto [graph, marks] = declare(256);
    Executor executor(device(), std::move(graph));
    executor.execute();
    auto [larger, larger_marks] = declare(512);
    EXPECT_FALSE(executor.update(std::move(larger)));
    executor.execute();
    EXPECT_EQ(read_as<std::uint32_t>(executor, larger_marks), std::vector<std::uint32_t>(128, 4));
}

TEST_F(UpdateTest, APlanIsFollowedByOthersOfItsPolicy) {
    Policy tight;
    tight.memory_budget_bytes = 4096;
    const auto declare = [](std::uint64_t bytes) {
        Graph graph("sized");
        graph.export_resource(
            add_mark(graph, "mark", graph.create_persistent_buffer("marks", {bytes}), 4), "");
        return graph;
    };
    for (const bool given : {false, true}) {
        Graph graph = declare(256);
        Plan plan = make_plan(device(), graph, tight);
        Executor executor(
            device(), std::move(graph), std::move(plan), {}, given ? tight : Policy{});
        executor.execute();
        const std::string text = error_of([&] { (void)executor.update(declare(1 << 20)); });
        EXPECT_EQ(text.find("budget") != std::string::npos, given) << text;
    }
}

TEST_F(UpdateTest, AMistakeLeavesTheOldGraph) {
    Frame first = frame(1, 2);
    Executor executor(device(), std::move(first.graph));
    executor.execute();
    Frame second = frame(1, 2);
    second.graph.export_resource(BufferHandle{}, "nothing");
    EXPECT_NE(error_of([&] { (void)executor.update(std::move(second.graph)); }), "");
    executor.execute();
    EXPECT_EQ(read_as<std::uint32_t>(executor, first.marks)[0], 2u);
}

} // namespace
} // namespace ockham

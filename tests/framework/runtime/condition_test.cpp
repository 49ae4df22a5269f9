// SPDX-License-Identifier: Apache-2.0
// Conditional passes: every combination of answers, one after another, with exact results.
#include "framework/runtime/executor.hpp"
#include "tests/framework/runtime/small_passes.hpp"
#include "tests/support/gpu_fixture.hpp"

namespace ockham {
namespace {

using test::add_mark;
using test::add_numbers;
using test::add_one;
using test::read_as;

class ConditionTest : public test::GpuTest {};

struct Conditional {
    Graph graph{"conditional"};
    Condition a, b;
    BufferHandle marks, chosen;
};

/// marks += 1, 10 if a, 100 if a and b, 1000 unless b; chosen = from one branch of b or the other.
Conditional conditional() {
    Conditional c;
    Graph& graph = c.graph;
    c.a = graph.add_condition("a");
    c.b = graph.add_condition("b");
    c.marks = graph.create_persistent_buffer("marks", {256});
    c.marks = add_mark(graph, "always", c.marks, 1);
    BufferHandle choice = graph.create_buffer("choice", {256});
    {
        const GuardScope when_a = graph.when(c.a);
        c.marks = add_mark(graph, "if_a", c.marks, 10);
        const GuardScope when_b = graph.when(c.b);
        c.marks = add_mark(graph, "if_a_and_b", c.marks, 100);
    }
    {
        const GuardScope unless_b = graph.unless(c.b);
        c.marks = add_mark(graph, "unless_b", c.marks, 1000);
        choice = add_numbers(graph, "choose_7", choice, 7);
    }
    {
        const GuardScope when_b = graph.when(c.b);
        choice = add_numbers(graph, "choose_20", choice, 20);
    }
    c.chosen = add_one(graph, "next", choice, graph.create_buffer("chosen", {256}));
    graph.export_resource(c.marks, "checked");
    graph.export_resource(c.chosen, "checked");
    return c;
}

TEST_F(ConditionTest, EveryCombination) {
    Conditional c = conditional();
    Executor executor(device(), std::move(c.graph));
    std::uint32_t expected = 0;
    for (const std::uint32_t answers : {0u, 1u, 2u, 3u, 1u, 3u, 0u, 2u}) {
        const bool a = answers & 1, b = answers & 2;
        executor.set(c.a, a);
        executor.set(c.b, b);
        executor.execute();
        expected += 1 + (a ? 10 : 0) + (a && b ? 100 : 0) + (b ? 0 : 1000);
        EXPECT_EQ(
            read_as<std::uint32_t>(executor, c.marks), std::vector<std::uint32_t>(64, expected))
            << answers;
        const auto chosen = read_as<std::uint32_t>(executor, c.chosen);
        for (std::uint32_t i = 0; i < 64; ++i) ASSERT_EQ(chosen[i], i + (b ? 21 : 8)) << answers;
    }
}

TEST_F(ConditionTest, TimesSayWhatWasSkipped) {
    Conditional c = conditional();
    Executor executor(device(), std::move(c.graph));
    const auto skipped = [&] {
        executor.execute();
        std::vector<std::string> names;
        for (const PassTime& time : executor.times()) {
            if (time.skipped) names.push_back(time.pass);
        }
        EXPECT_EQ(executor.times().size(), 7u);
        return names;
    };
    EXPECT_EQ(skipped(), (std::vector<std::string>{"unless_b", "choose_7"})); // true until set
    executor.set(c.a, false);
    executor.set(c.b, false);
    EXPECT_EQ(skipped(), (std::vector<std::string>{"if_a", "if_a_and_b", "choose_20"}));
}

/// A skipped raster pass clears nothing either, and images keep their layouts.
TEST_F(ConditionTest, SkippedRasterPassesKeepTheirTargets) {
    Graph graph("raster");
    const Condition draw = graph.add_condition("draw");
    constexpr ImageDesc desc{.format = VK_FORMAT_R32_UINT, .width = 7, .height = 5};
    ImageHandle picture = graph.create_persistent_image("picture", desc);
    {
        const GuardScope guard = graph.when(draw);
        PassBuilder pass = graph.add_raster_pass("clear");
        picture = pass.color(picture, LoadOp::clear, {5, 0, 0, 0});
    }
    PassBuilder pass = graph.add_compute_pass("add");
    pass.sample("newest", picture);
    pass.sample("oldest", picture);
    ImageHandle sum = pass.write("target", graph.create_image("sum", desc));
    pass.record([](Commands& commands) {
        const std::uint32_t value = 1;
        commands.dispatch({.shader = "test/recur_image.comp", .push = as_push(value)}, {1, 1, 1});
    });
    graph.export_resource(sum, "checked");
    Executor executor(device(), std::move(graph));
    executor.set(draw, false);
    executor.execute();
    EXPECT_EQ(executor.read(sum).at(6, 4, 0), 1.0f); // the picture is zero
    executor.set(draw, true);
    executor.execute();
    EXPECT_EQ(executor.read(sum).at(6, 4, 0), 11.0f);
    executor.set(draw, false);
    executor.execute();
    EXPECT_EQ(executor.read(sum).at(6, 4, 0), 11.0f);
}

} // namespace
} // namespace ockham

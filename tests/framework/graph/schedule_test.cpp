// SPDX-License-Identifier: Apache-2.0
// Order and queues: what comes together, what waits for what, what stays on one queue.
#include "framework/graph/verify.hpp"
#include "samples/chart/graph_families.hpp"
#include "tests/framework/graph/plan_lines.hpp"
#include "tests/framework/graph/random_graph.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <thread>

namespace ockham {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Policy batched(double memory) { return {.order = Order::batched, .batch_memory = memory}; }

/// Writes a new buffer of its own name from others.
BufferHandle add(Graph& graph, const std::string& name, std::initializer_list<BufferHandle> from,
    QueueWish queue = QueueWish::main) {
    BufferHandle out = graph.create_buffer(name, {1024});
    auto pass = graph.add_compute_pass(name);
    int count = 0;
    for (const BufferHandle& one : from) pass.read(fmt::format("in{}", count++), one);
    return pass.prefer(queue).write("out", out);
}

/// Two chains of three, one after the other.
Graph two_chains() {
    Graph graph("g");
    BufferHandle a = add(graph, "a0", {}), b;
    for (int i = 1; i < 3; ++i) a = add(graph, fmt::format("a{}", i), {a});
    b = add(graph, "b0", {});
    for (int i = 1; i < 3; ++i) b = add(graph, fmt::format("b{}", i), {b});
    graph.export_resource(a, "wanted");
    graph.export_resource(b, "wanted");
    return graph;
}

TEST(Order, DeclaredStaysAsDeclared) {
    const Graph graph = two_chains();
    EXPECT_EQ(order_line(graph.declaration(), compile(graph.declaration())), "a0 a1 a2 b0 b1 b2");
}

TEST(Order, BatchedBringsIndependentPassesTogether) {
    const Graph graph = two_chains();
    const Plan plan = compile(graph.declaration(), {}, batched(kInfinity));
    EXPECT_EQ(order_line(graph.declaration(), plan), "a0 b0 a1 b1 a2 b2");
}

TEST(Order, NoMoreMemoryThanAllowed) {
    // Both chains at once need four buffers where one needs two; the exported ones are always
    // there. 'b0' may have the place of 'a0' as soon as that is dead.
    const Graph graph = two_chains();
    EXPECT_EQ(order_line(graph.declaration(), compile(graph.declaration(), {}, batched(0))),
        "a0 a1 b0 a2 b1 b2");
    EXPECT_EQ(order_line(graph.declaration(), compile(graph.declaration(), {}, batched(1))),
        "a0 b0 a1 b1 a2 b2");
}

TEST(Order, BatchesHoldBarriersOfSeveralPasses) {
    const Graph graph = random16(100);
    const std::uint32_t declared = compile(graph.declaration()).batches();
    EXPECT_LT(compile(graph.declaration(), {}, batched(0)).batches(), declared / 2);
}

/// The most bytes that live at a step in the order of the plan, what is kept included.
std::uint64_t live_bytes(const Declaration& declaration, const Plan& plan) {
    std::uint64_t most = 0;
    for (std::uint32_t step = 0; step < plan.steps.size(); ++step) {
        std::uint64_t live = 0;
        for (const Placement& placement : plan.placements) {
            const ResourceDecl& resource = declaration.resources[placement.resource];
            const bool kept = resource.exported || resource.lifetime != Lifetime::transient;
            if (kept || (placement.first_step <= step && step <= placement.last_step))
                live += placement.bytes;
        }
        most = std::max(most, live);
    }
    return most;
}

/// By definition: passes that touch the same resource, one of them writing, keep their order, and
/// so do those with side effects.
void expect_order_kept(const Declaration& declaration, const Plan& plan, std::uint64_t seed) {
    const auto conflict = [&](PassId a, PassId b) {
        if (!declaration.passes[a].side_effect.empty() &&
            !declaration.passes[b].side_effect.empty())
            return true;
        for (const Use& x : declaration.uses_of(a))
            for (const Use& y : declaration.uses_of(b))
                if (x.resource == y.resource && (writes(x.access) || writes(y.access))) return true;
        return false;
    };
    for (std::size_t i = 0; i < plan.steps.size(); ++i)
        for (std::size_t k = 0; k < i; ++k)
            ASSERT_FALSE(plan.steps[k].pass > plan.steps[i].pass &&
                         conflict(plan.steps[k].pass, plan.steps[i].pass))
                << "seed " << seed << ": " << declaration.passes[plan.steps[i].pass].name;
}

TEST(Order, OfRandomGraphsKeepsDependencesAndTheLimit) {
    std::uint64_t batches = 0, batches_declared = 0, moved = 0;
    for (std::uint64_t seed = 0; seed < 300; ++seed) {
        RandomGraph random(seed, 60);
        const Declaration& declaration = random.graph().declaration();
        const Plan declared = compile(declaration);
        batches_declared += declared.batches();
        for (const double slack : {0.0, 0.1, kInfinity}) {
            const Plan plan = compile(declaration, {}, batched(slack));
            expect_order_kept(declaration, plan, seed);
            ASSERT_EQ(plan.steps.size(), declared.steps.size());
            ASSERT_EQ(plan.bytes_lower_bound, declared.bytes_lower_bound);
            if (slack < kInfinity) {
                ASSERT_LE(static_cast<double>(live_bytes(declaration, plan)),
                    (1 + slack) * static_cast<double>(plan.bytes_lower_bound))
                    << "seed " << seed << ", slack " << slack;
            }
            moved += order_line(declaration, plan) != order_line(declaration, declared);
            if (slack == 0) batches += plan.batches();
        }
    }
    EXPECT_GT(moved, 300u);
    EXPECT_LT(batches, batches_declared);
}

/// "main: a | async: b < main 1 | ...": submissions in order, their steps and what they wait for.
std::string submission_line(const Declaration& declaration, const Plan& plan) {
    std::string line;
    for (const Submission& submission : plan.submissions) {
        line += fmt::format("{}{}:", line.empty() ? "" : " | ", submission.queue);
        for (std::uint32_t i = 0; i < submission.step_count; ++i)
            line += " " + declaration.passes[plan.steps[submission.first_step + i].pass].name;
        for (std::uint32_t i = 0; i < submission.wait_count; ++i) {
            const Wait& wait = plan.waits[submission.first_wait + i];
            line += fmt::format(" < {}.{}", wait.queue, wait.value);
        }
    }
    return line;
}

const QueueFamily kMain{}, kCompute{.graphics = false}, kTransfer{false, false, true};

/// start -> side (async) and start -> main -> end <- side
Graph fork() {
    Graph graph("g");
    const BufferHandle start = add(graph, "start", {});
    const BufferHandle side = add(graph, "side", {start}, QueueWish::async_compute);
    const BufferHandle copy = add(graph, "copy", {start});
    const BufferHandle more = add(graph, "more", {});
    const BufferHandle main = add(graph, "main", {more, copy});
    graph.export_resource(add(graph, "end", {main, side}), "wanted");
    return graph;
}

TEST(Queues, OneFamilyCollapses) {
    const Graph graph = fork();
    const std::string one = "0: start side copy more main end";
    const auto line = [&](const Capabilities& capabilities, const Policy& policy) {
        const Plan plan = compile(graph.declaration(), capabilities, policy);
        EXPECT_EQ(plan.queues.size(), 1u);
        EXPECT_TRUE(plan.waits.empty());
        return submission_line(graph.declaration(), plan);
    };
    EXPECT_EQ(line({}, {}), one);
    EXPECT_EQ(line({.families = {kMain}}, {}), one);
    EXPECT_EQ(line({.families = {kMain, kTransfer}}, {}), one);
    EXPECT_EQ(line({.families = {kMain, kCompute}}, {.async_queues = false}), one);
}

TEST(Queues, AFamilyOfItsOwnComesBeforeASecondQueue) {
    Graph graph("g");
    const BufferHandle side = add(graph, "side", {}, QueueWish::async_compute);
    const BufferHandle main = add(graph, "main", {});
    graph.export_resource(add(graph, "end", {main, side}), "wanted");
    const auto queues = [&](std::vector<QueueFamily> families) {
        std::string line;
        for (const PlanQueue& queue :
            compile(graph.declaration(), {.families = std::move(families)}).queues)
            line += fmt::format("{}.{} ", queue.family, queue.index);
        return line;
    };
    const QueueFamily two{.queues = 2};
    EXPECT_EQ(queues({kMain, kCompute}), "0.0 1.0 ");
    EXPECT_EQ(queues({kTransfer, kCompute, kMain}), "2.0 1.0 ");
    EXPECT_EQ(queues({two, kCompute}), "0.0 1.0 ");
    EXPECT_EQ(queues({two}), "0.0 0.1 ");
    EXPECT_EQ(queues({two, kMain}), "0.0 0.1 ");
    EXPECT_EQ(queues({kMain, kMain}), "0.0 1.0 ");
}

TEST(Queues, SubmissionsAreCutOnlyWhereSomethingWaits) {
    const Graph graph = fork();
    // Two queues of one family: 'copy' reads what 'side' reads, and neither waits for the other.
    const Plan plan = compile(graph.declaration(), {.families = {{.queues = 2}}});
    EXPECT_EQ(submission_line(graph.declaration(), plan),
        "0: start | 1: side < 0.1 | 0: copy more main | 0: end < 1.1");
}

TEST(Queues, OneFamilyAfterTheOtherOwnsATransient) {
    // 'start' goes to the other family and comes back, so 'copy' waits for 'side'.
    const Graph graph = fork();
    EXPECT_EQ(compile(graph.declaration(), {.families = {kMain, kCompute}}).queues.size(), 1u);
}

TEST(Queues, AChainHasNothingToGain) {
    Graph graph("g");
    BufferHandle last = add(graph, "p0", {});
    for (int i = 1; i < 6; ++i)
        last = add(graph, fmt::format("p{}", i), {last},
            i % 2 ? QueueWish::async_compute : QueueWish::main);
    graph.export_resource(last, "wanted");
    EXPECT_EQ(compile(graph.declaration(), {.families = {kMain, kCompute}}).queues.size(), 1u);
}

TEST(Queues, WaitsThatFollowFromOthersAreDropped) {
    Graph graph("g");
    const BufferHandle a = add(graph, "a", {});
    const BufferHandle b = add(graph, "b", {a}, QueueWish::async_compute);
    const BufferHandle c = add(graph, "c", {a, b}, QueueWish::async_compute);
    const BufferHandle d = add(graph, "d", {});
    graph.export_resource(add(graph, "e", {b, c, d}), "wanted");
    const Plan plan = compile(graph.declaration(), {.families = {{.queues = 2}}});
    EXPECT_EQ(
        submission_line(graph.declaration(), plan), "0: a | 1: b c < 0.1 | 0: d | 0: e < 1.1");
}

TEST(Queues, KeptResourcesOfSeveralFamiliesAreConcurrent) {
    Graph graph("g");
    BufferHandle kept = graph.create_persistent_buffer("kept", {1024});
    const BufferHandle a = add(graph, "a", {kept}, QueueWish::async_compute);
    const BufferHandle b = add(graph, "b", {kept});
    graph.export_resource(add(graph, "c", {a, b}), "wanted");
    const Plan plan = compile(graph.declaration(), {.families = {kMain, kCompute}});
    ASSERT_EQ(plan.queues.size(), 2u);
    EXPECT_EQ(plan.concurrent, (std::vector<std::uint8_t>{1, 0, 0, 0}));
    EXPECT_EQ(compile(graph.declaration(), {.families = {{.queues = 2}}}).concurrent,
        (std::vector<std::uint8_t>{0, 0, 0, 0}));
}

/// The verifier's word on what this phase and place() decide, with wishes at random.
TEST(Queues, OfRandomGraphsAreSound) {
    using enum Violation::Kind;
    const std::vector<std::vector<QueueFamily>> devices{
        {kMain}, {{.queues = 2}}, {kMain, kCompute}, {kCompute, kTransfer, kMain}};
    std::size_t spread = 0;
    for (std::uint64_t seed = 0; seed < 400; ++seed) {
        RandomGraph random(seed, 60);
        Declaration declaration = random.graph().declaration();
        Pcg32 rng(seed);
        for (PassDecl& pass : declaration.passes)
            if (pass.kind != PassKind::raster && rng.below(3) == 0)
                pass.queue = pass.kind == PassKind::transfer ? QueueWish::transfer
                                                             : QueueWish::async_compute;
        const Capabilities capabilities{.families = devices[seed % devices.size()]};
        const Policy policy = seed % 3 ? Policy{} : batched(0.25);
        const Plan plan = compile(declaration, capabilities, policy);
        spread += plan.queues.size() > 1;
        for (const Violation& violation : verify(declaration, plan, capabilities))
            if (violation.kind == order || violation.kind == submission ||
                violation.kind == placement || violation.kind == alias)
                FAIL() << "seed " << seed << ": " << name_of(violation.kind) << ": "
                       << violation.text;
    }
    EXPECT_GT(spread, 150u);
}

TEST(Determinism, EightThreadsMakeOnePlan) {
    const Graph graph = random16(150);
    std::vector<Plan> plans(8);
    std::vector<std::thread> threads;
    for (Plan& plan : plans)
        threads.emplace_back([&] {
            for (int i = 0; i < 20; ++i)
                plan = compile(graph.declaration(), {.families = {kMain, kCompute}}, batched(0.1));
        });
    for (std::thread& thread : threads) thread.join();
    for (const Plan& plan : plans) EXPECT_EQ(plan, plans[0]);
}

} // namespace
} // namespace ockham

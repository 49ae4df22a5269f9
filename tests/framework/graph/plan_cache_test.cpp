// SPDX-License-Identifier: Apache-2.0
#include "framework/core/error.hpp"
#include "framework/graph/plan_cache.hpp"
#include "samples/chart/graph_families.hpp"
#include "tests/framework/graph/random_graph.hpp"

#include <gtest/gtest.h>

#include <thread>

namespace ockham {
namespace {

TEST(PlanCache, AnEqualDeclarationFindsThePlan) {
    PlanCache cache;
    const auto first = cache.get(random16(30));
    EXPECT_EQ(cache.get(random16(30)), first); // the same object
    EXPECT_EQ(*first, compile(random16(30).declaration()));
    EXPECT_NE(cache.get(random16(31)), first);
    EXPECT_NE(cache.get(random16(30, 2)), first);
    EXPECT_EQ(cache.size(), 3u);
    cache.clear();
    EXPECT_EQ(cache.size(), 0u);
    EXPECT_NE(cache.get(random16(30)), first);
}

TEST(PlanCache, CapabilitiesAndPolicyMatter) {
    const Graph graph = chain2(5);
    PlanCache cache;
    std::size_t plans = 0;
    const auto expect_new = [&](const Capabilities& capabilities, const Policy& policy) {
        (void)cache.get(graph, capabilities, policy);
        EXPECT_EQ(cache.size(), ++plans);
        (void)cache.get(graph, capabilities, policy);
        EXPECT_EQ(cache.size(), plans);
    };
    expect_new({}, {});
    expect_new({.families = {{}}}, {});
    expect_new({.families = {{}, {.graphics = false}}}, {});
    expect_new({.families = {{}, {.graphics = false, .queues = 2}}}, {});
    Capabilities granular, small_buffers, small_images, few_layers;
    granular.buffer_image_granularity = 64;
    small_buffers.max_buffer_bytes = 1u << 30;
    small_images.max_image_extent = 4096;
    few_layers.max_image_layers = 256;
    for (const Capabilities& one : {granular, small_buffers, small_images, few_layers})
        expect_new(one, {});
    expect_new({}, {.order = Order::batched});
    expect_new({}, {.order = Order::batched, .batch_memory = 0.5});
    expect_new({}, {.async_queues = false});
    expect_new({}, {.alias_memory = false});
    expect_new({}, {.memory_budget_bytes = 1u << 30});
}

TEST(PlanCache, ForgetsWhatWasUsedLongestAgo) {
    PlanCache cache(2);
    const auto a = cache.get(chain2(1)), b = cache.get(chain2(2));
    EXPECT_EQ(cache.get(chain2(1)), a); // now b is the older
    (void)cache.get(chain2(3));
    EXPECT_EQ(cache.size(), 2u);
    EXPECT_EQ(cache.get(chain2(1)), a);
    EXPECT_NE(cache.get(chain2(2)), b);
}

TEST(PlanCache, MakesAPlanOnlyWhereThereIsNone) {
    const Graph graph = chain2(3);
    PlanCache cache;
    int made = 0;
    const auto make = [&] {
        ++made;
        return compile(graph.declaration());
    };
    (void)cache.get(graph, {}, {}, make);
    (void)cache.get(graph, {}, {}, make);
    EXPECT_EQ(made, 1);
    (void)cache.get(graph, {}, {.paranoid = true}, make);
    EXPECT_EQ(made, 2);
}

TEST(PlanCache, ErrorsOfPlanningLeaveNothing) {
    PlanCache cache;
    EXPECT_THROW((void)cache.get(chain2(3), {}, {.memory_budget_bytes = 1}), Error);
    EXPECT_EQ(cache.size(), 0u);
}

TEST(PlanCacheDeathTest, ParanoidNoticesAnotherPlan) {
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    const Graph graph = chain2(3);
    PlanCache cache;
    const Policy policy{.paranoid = true};
    (void)cache.get(graph, {}, policy);
    (void)cache.get(graph, {}, policy); // equal
    EXPECT_DEATH(
        (void)cache.get(graph, {}, policy, [] { return compile(chain2(2).declaration()); }),
        "graph 'chain2': its plan differs from the kept plan");
}

TEST(PlanCache, ManyThreadsGetOnePlan) {
    PlanCache cache;
    std::vector<std::shared_ptr<const Plan>> plans(8);
    std::vector<std::thread> threads;
    for (auto& plan : plans)
        threads.emplace_back([&] { plan = cache.get(RandomGraph(7, 100).graph()); });
    for (std::thread& thread : threads) thread.join();
    for (const auto& plan : plans) EXPECT_EQ(*plan, *plans[0]);
    EXPECT_EQ(cache.size(), 1u);
    EXPECT_EQ(cache.get(RandomGraph(7, 100).graph()), cache.get(RandomGraph(7, 100).graph()));
}

} // namespace
} // namespace ockham

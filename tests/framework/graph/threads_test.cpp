// SPDX-License-Identifier: Apache-2.0
// Plans from several threads at once: different graphs, one shared graph, one shared cache. Built
// with ThreadSanitizer, whose word is the test, and with a main() of its own, so that all of it is
// instrumented.
#include "framework/graph/plan_cache.hpp"
#include "samples/chart/graph_families.hpp"
#include "tests/framework/graph/random_graph.hpp"

#include <atomic>
#include <cstdio>
#include <thread>

int main() {
    using namespace ockham;
    const Capabilities capabilities{.families = {{}, {.graphics = false}}};
    const Policy policy{.order = Order::batched, .batch_memory = 0.1};
    const Graph shared = random16(60);
    const Plan expected = compile(shared.declaration(), capabilities, policy);
    PlanCache cache(4);
    std::atomic<int> different = 0;
    std::vector<std::thread> threads;
    for (std::uint64_t thread = 0; thread < 8; ++thread)
        threads.emplace_back([&, thread] {
            for (std::uint64_t round = 0; round < 10; ++round) {
                different += !(compile(shared.declaration(), capabilities, policy) == expected);
                different += !(*cache.get(random16(60), capabilities, policy) == expected);
                RandomGraph own(8 * round + thread);
                const Plan plan = compile(own.graph().declaration());
                different += !(*cache.get(own.graph()) == plan);
            }
        });
    for (std::thread& thread : threads) thread.join();
    if (different) std::fprintf(stderr, "%d plans differ between threads\n", different.load());
    return different != 0;
}

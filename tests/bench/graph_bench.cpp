// SPDX-License-Identifier: Apache-2.0
// What planning costs and gives: thread CPU time for each pass of a full plan, of a plan found
// again, of declaring; heap bytes per byte of the lower bound; batches of barriers against memory.
// Arguments are plan files of other graphs. docs/graph_performance.md explains the figures.
#include "framework/core/error.hpp"
#include "framework/graph/compile.hpp"
#include "framework/graph/explain/explain.hpp"
#include "framework/graph/explain/plan_file.hpp"
#include "framework/graph/plan_cache.hpp"
#include "samples/chart/graph_families.hpp"
#include "tests/framework/graph/random_graph.hpp"

#include <benchmark/benchmark.h>
#include <nlohmann/json.hpp>

#include <ctime>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>

namespace ockham {
namespace {

using Family = std::function<Graph(std::uint32_t passes)>;

double thread_cpu_us() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

/// Runs `body` as often as the benchmark wants; counts microseconds for each pass.
template <class Body>
void run(benchmark::State& state, std::size_t passes, Body body) {
    const double start = thread_cpu_us();
    for (auto _ : state) body();
    const double us = thread_cpu_us() - start;
    state.counters["us_per_pass"] =
        us / static_cast<double>(state.iterations()) / static_cast<double>(passes);
}

void compile_again(benchmark::State& state, const Declaration& declaration) {
    double ratio = 0;
    run(state, declaration.passes.size(), [&] {
        const Plan plan = compile(declaration);
        ratio = memory_ratio(plan);
    });
    state.counters["heap_ratio"] = ratio;
}

void add_family(const std::string& name, const Family& family) {
    const auto add = [](const std::string& title, auto body) {
        auto* one = benchmark::RegisterBenchmark(title.c_str(), [body](benchmark::State& state) {
            body(state, static_cast<std::uint32_t>(state.range(0)));
            state.SetComplexityN(state.range(0));
        });
        for (const int passes : {10, 50, 100, 200, 1000, 10000}) one->Arg(passes);
        one->Unit(benchmark::kMicrosecond);
        return one;
    };
    add("compile/" + name, [family](benchmark::State& state, std::uint32_t passes) {
        const Graph graph = family(passes);
        compile_again(state, graph.declaration());
    })->Complexity(benchmark::oNLogN);
    // The graph is still there, and its plan is asked for again.
    add("retained/" + name, [family](benchmark::State& state, std::uint32_t passes) {
        const Graph graph = family(passes);
        PlanCache cache;
        (void)cache.get(graph);
        run(state, passes, [&] { benchmark::DoNotOptimize(cache.get(graph)); });
    });
    // It is declared anew, texts and hash included, and its plan is found.
    add("redeclare/" + name, [family](benchmark::State& state, std::uint32_t passes) {
        PlanCache cache;
        (void)cache.get(family(passes));
        run(state, passes, [&] { benchmark::DoNotOptimize(cache.get(family(passes))); });
    });
}

/// Batches of barriers, barriers and bytes of the batched order with this much more memory, summed
/// over the graphs, against the declared order.
void add_frontier(const std::string& name,
    const std::function<void(const std::function<void(const Declaration&)>&)>& each_graph) {
    constexpr double kSlacks[] = {0, 0.05, 0.1, 0.25, 0.5, std::numeric_limits<double>::infinity()};
    for (const double slack : kSlacks) {
        benchmark::RegisterBenchmark(fmt::format("frontier/{}/{}", name, slack).c_str(),
            [each_graph, slack](benchmark::State& state) {
                struct Sum {
                    double batches = 0, barriers = 0, bytes = 0, bound = 0;
                    void add(const Plan& plan) {
                        batches += plan.batches();
                        barriers += static_cast<double>(plan.barriers.size());
                        bytes += static_cast<double>(plan.bytes_peak);
                        bound += static_cast<double>(plan.bytes_lower_bound);
                    }
                } declared, batched;
                for (auto _ : state) {
                    declared = batched = {};
                    each_graph([&](const Declaration& declaration) {
                        declared.add(compile(declaration));
                        batched.add(compile(
                            declaration, {}, {.order = Order::batched, .batch_memory = slack}));
                    });
                }
                state.counters["batches"] = batched.batches;
                state.counters["batches_declared"] = declared.batches;
                state.counters["barriers"] = batched.barriers;
                state.counters["barriers_declared"] = declared.barriers;
                state.counters["heap_ratio"] = batched.bytes / batched.bound;
                state.counters["heap_ratio_declared"] = declared.bytes / declared.bound;
            })
            ->Unit(benchmark::kMillisecond)
            ->Iterations(1);
    }
}

/// How the heaps of many graphs compare with their lower bounds.
void add_heap_ratios() {
    benchmark::RegisterBenchmark("heap_ratio/corpus",
        [](benchmark::State& state) {
            std::vector<double> ratios;
            for (auto _ : state) {
                ratios.clear();
                const auto add = [&](const Declaration& declaration) {
                    ratios.push_back(memory_ratio(compile(declaration)));
                };
                for (const std::uint32_t passes : {10u, 50u, 100u, 200u, 1000u, 10000u}) {
                    add(chain2(passes).declaration());
                    add(random16(passes).declaration());
                }
                for (std::uint64_t seed = 0; seed < 1000; ++seed)
                    add(RandomGraph(seed).graph().declaration());
            }
            std::sort(ratios.begin(), ratios.end());
            const auto quantile = [&](double q) {
                return ratios[static_cast<std::size_t>(q * static_cast<double>(ratios.size() - 1))];
            };
            state.counters["median"] = quantile(0.5);
            state.counters["p95"] = quantile(0.95);
            state.counters["p99"] = quantile(0.99);
            state.counters["max"] = ratios.back();
        })
        ->Unit(benchmark::kMillisecond)
        ->Iterations(1);
}

void add_all() {
    add_family("chain2", chain2);
    add_family("random16", [](std::uint32_t passes) { return random16(passes); });
    add_heap_ratios();
    const auto one = [](Graph (*family)(std::uint32_t)) {
        return [family](const auto& visit) { visit(family(200).declaration()); };
    };
    add_frontier("chain2", one(chain2));
    add_frontier("random16", one([](std::uint32_t passes) { return random16(passes); }));
    add_frontier("random1000", [](const auto& visit) {
        for (std::uint64_t seed = 0; seed < 1000; ++seed)
            visit(RandomGraph(seed).graph().declaration());
    });
}

void add_file(const std::filesystem::path& path) {
    std::ifstream in(path);
    if (!in) fail_input("{}: cannot be read; give a plan file", path.string());
    const auto declaration =
        std::make_shared<Declaration>(load_plan_file(nlohmann::json::parse(in)).declaration);
    const std::string name = path.stem().string();
    benchmark::RegisterBenchmark(("compile/" + name).c_str(), [declaration](auto& state) {
        compile_again(state, *declaration);
    })->Unit(benchmark::kMicrosecond);
    add_frontier(name, [declaration](const auto& visit) { visit(*declaration); });
}

} // namespace
} // namespace ockham

int main(int argc, char** argv) {
    benchmark::Initialize(&argc, argv);
    try {
        ockham::add_all();
        for (int i = 1; i < argc; ++i) ockham::add_file(argv[i]);
    } catch (const std::exception& error) {
        fmt::print(stderr, "graph_bench: {}\n", error.what());
        return 2;
    }
    benchmark::RunSpecifiedBenchmarks();
    return 0;
}

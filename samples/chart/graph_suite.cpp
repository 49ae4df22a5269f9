// SPDX-License-Identifier: Apache-2.0
#include "samples/chart/graph_suite.hpp"

#include "framework/graph/compile.hpp"
#include "framework/graph/explain/explain.hpp"
#include "framework/graph/plan_cache.hpp"
#include "samples/chart/graph_families.hpp"

#include <ctime>
#include <functional>

namespace ockham::chart {
namespace {

constexpr const char* kScene = "generated graphs";

struct Family {
    const char* name;
    const char* legend;
    std::function<Graph(std::uint32_t)> make;
};
const Family kFamilies[] = {{"chain2", "chain", chain2},
    {"random16", "0 to 16 earlier passes", [](std::uint32_t passes) { return random16(passes); }}};

double thread_cpu_us() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

/// Microseconds of the thread's CPU time that `body` takes, from as many calls as fill 5 ms.
double cpu_us(const std::function<void()>& body) {
    const double start = thread_cpu_us();
    double us = 0;
    int calls = 0;
    do {
        body();
        ++calls;
        us = thread_cpu_us() - start;
    } while (us < 5000);
    return us / calls;
}

/// What planning costs at one size.
class Planning : public Subject {
public:
    Planning(const Family& family, std::uint32_t passes)
        : family_(family), passes_(passes), graph_(family.make(passes)) {
        (void)cache_.get(graph_);
    }

    std::vector<Row> measure() override {
        Plan plan;
        const double compiled = cpu_us([&] { plan = compile(graph_.declaration()); });
        const double again = cpu_us([&] { (void)cache_.get(graph_); });
        const double anew = cpu_us([&] { (void)cache_.get(family_.make(passes_)); });
        const double count = passes_;
        return {{.knob = count,
            .values = {{"compile_us", compiled}, {"compile_us_per_pass", compiled / count},
                {"retained_us", again}, {"redeclare_us", anew},
                {"heap_mib", static_cast<double>(plan.bytes_peak) / (1 << 20)},
                {"bound_mib", static_cast<double>(plan.bytes_lower_bound) / (1 << 20)},
                {"heap_ratio", memory_ratio(plan)}}}};
    }

private:
    const Family& family_;
    std::uint32_t passes_;
    Graph graph_;
    PlanCache cache_;
};

/// What Order::batched trades: memory for fewer batches of barriers.
class Batching : public Subject {
public:
    Batching(const Family& family, double slack) : graph_(family.make(200)), slack_(slack) {}

    std::vector<Row> measure() override {
        const Policy policy =
            slack_ < 0 ? Policy{} : Policy{.order = Order::batched, .batch_memory = slack_};
        const Plan plan = compile(graph_.declaration(), {}, policy);
        return {{.knob = slack_,
            .values = {{"batches", plan.batches()}, {"heap_ratio", memory_ratio(plan)}}}};
    }

private:
    Graph graph_;
    double slack_;
};

/// Extra memory that batching may take; below 0: the declared order.
constexpr double kSlacks[] = {-1, 0, 0.05, 0.1, 0.25, 1};

class GraphSuite : public Suite {
public:
    explicit GraphSuite(Context& context) : context_(context) {}
    std::string name() const override { return "graph"; }
    std::vector<Job> jobs() override;
    std::unique_ptr<Subject> open(const Job& job) override;
    Section report(const Store& store, const std::vector<Point>& points) override;

private:
    std::vector<std::uint32_t> sizes() const {
        if (context_.options.quick) return {10, 30, 100, 300, 1000};
        return {10, 30, 100, 300, 1000, 3000, 10000};
    }

    Context& context_;
};

std::vector<Job> GraphSuite::jobs() {
    std::vector<Job> jobs;
    for (const Family& family : kFamilies) {
        for (const std::uint32_t passes : sizes()) {
            jobs.push_back({.suite = name(),
                .scene = kScene,
                .series = family.name,
                .setting = fmt::format("{} passes", passes),
                .inputs = cpu_name(),
                .command = fmt::format(
                    "graph_bench --benchmark_filter=compile/{}/{}$", family.name, passes)});
        }
    }
    const Family& family = kFamilies[1];
    for (const double slack : kSlacks) {
        jobs.push_back({.suite = name(),
            .scene = kScene,
            .series = fmt::format("{}, batched", family.name),
            .setting = slack < 0 ? "declared order" : fmt::format("extra memory {}", slack),
            .inputs = {},
            .command = fmt::format("graph_bench --benchmark_filter=frontier/{}/{}$", family.name,
                std::max(slack, 0.0)),
            .repeats = 1});
    }
    return jobs;
}

std::unique_ptr<Subject> GraphSuite::open(const Job& job) {
    const Family& family = job.series.starts_with(kFamilies[0].name) ? kFamilies[0] : kFamilies[1];
    for (const std::uint32_t passes : sizes())
        if (job.setting == fmt::format("{} passes", passes))
            return std::make_unique<Planning>(family, passes);
    for (const double slack : kSlacks)
        if (job.setting == fmt::format("extra memory {}", slack))
            return std::make_unique<Batching>(family, slack);
    return std::make_unique<Batching>(family, -1.0);
}

Section GraphSuite::report(const Store&, const std::vector<Point>& points) {
    const auto curves = [&](Plot& plot, const char* value, const std::string& what) {
        plot.y.value = value;
        for (const Family& family : kFamilies)
            plot.curves.push_back(curve(points, kScene, family.name, plot, what + family.legend));
    };
    Plot time{.name = "graph_compile",
        .question = "What does planning a graph cost?",
        .x = {"knob", "passes", true},
        .y = {"compile_us", "CPU time of one thread (µs)", true},
        .caption = "A graph is planned in full, found again because it was kept, or declared anew "
                   "with all its names and found by fingerprint. Each pass reads the one before "
                   "(chain), or 0 to 16 of all earlier ones."};
    curves(time, "retained_us", "kept: ");
    curves(time, "redeclare_us", "declared anew: ");
    curves(time, "compile_us", "planned: ");
    Plot heap{.name = "graph_heap",
        .question = "How near does the heap come to its lower bound?",
        .x = {"knob", "passes", true},
        .y = {"heap_ratio", "heap bytes per byte of the bound", false, Better::less},
        .marks = {{.label = "bound: the largest live set", .y = 1.0}},
        .caption = "No packing of the declared order can be smaller than the largest set of bytes "
                   "that live at a time."};
    curves(heap, "heap_ratio", "");
    Plot batches{.name = "graph_batches",
        .question = "What do fewer batches of barriers cost in memory?",
        .x = {"heap_ratio", "heap bytes per byte of the bound", false, Better::less},
        .y = {"batches", "batches of barriers", false, Better::less},
        .caption = "200 passes that read 0 to 16 earlier ones: as declared, and brought together "
                   "with more and more extra memory."};
    batches.curves.push_back(
        curve(points, kScene, "random16, batched", batches, "order declared, then batched"));
    return {.title = "Render graph",
        .text = "What <code>compile()</code> takes and gives, without a device.",
        .plots = {time, heap, batches}};
}

} // namespace

std::unique_ptr<Suite> make_graph_suite(Context& context) {
    return std::make_unique<GraphSuite>(context);
}

} // namespace ockham::chart

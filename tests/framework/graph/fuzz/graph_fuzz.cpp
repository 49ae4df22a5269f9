// SPDX-License-Identifier: Apache-2.0
// Plans random declarations, for random devices, and verifies each plan; damaged declarations must
// be refused with a code or give a sound plan. Built with sanitizers.
//   graph_fuzz [--first N] [--count N] [--seed N] [--threads N] [--figures file] [--verbose]
//              [--without parts|histories|guards|queues]...
// --seed N does one, --verbose shows it. Exit code 1: the first failure, and how to repeat it.
#include "framework/core/error.hpp"
#include "framework/core/timer.hpp"
#include "framework/graph/dump.hpp"
#include "framework/graph/explain.hpp"
#include "framework/graph/verify.hpp"
#include "tests/framework/graph/fuzz/corrupt.hpp"
#include "tests/framework/graph/random_declaration.hpp"

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace ockham {
namespace {

struct Arguments {
    std::uint64_t first = 0, count = 100000;
    std::uint32_t threads = 2;
    std::string figures;
    bool verbose = false;
    RandomOptions options;
};

struct Figures {
    std::uint64_t graphs = 0, steps = 0, barriers = 0, several_queues = 0;
    std::uint64_t damaged = 0, refused = 0;
    double compile_us = 0, verify_us = 0;
    std::vector<float> ratios; ///< heap bytes per byte of the lower bound

    void add(const Figures& other) {
        graphs += other.graphs;
        steps += other.steps;
        barriers += other.barriers;
        several_queues += other.several_queues;
        damaged += other.damaged;
        refused += other.refused;
        compile_us += other.compile_us;
        verify_us += other.verify_us;
        ratios.insert(ratios.end(), other.ratios.begin(), other.ratios.end());
    }

    std::string text(double seconds) {
        std::sort(ratios.begin(), ratios.end());
        const auto quantile = [&](double q) {
            return ratios.empty() ? 1.0f
                                  : ratios[static_cast<std::size_t>(
                                        q * static_cast<double>(ratios.size() - 1))];
        };
        const auto per_graph = [&](double value) { return value / static_cast<double>(graphs); };
        return fmt::format(
            "graph_fuzz: {} declarations in {:.1f} s ({:.0f} per s), all plans sound; {} steps, {} "
            "barriers, {:.1f} % on several queues; compile {:.0f} us, verify {:.0f} us each "
            "(sanitized); heap / lower bound p50 {:.3f}, p95 {:.3f}, max {:.3f}; {} of {} damaged "
            "ones refused, the others sound",
            graphs + damaged, seconds, static_cast<double>(graphs + damaged) / seconds, steps,
            barriers, 100 * per_graph(static_cast<double>(several_queues)), per_graph(compile_us),
            per_graph(verify_us), quantile(0.5), quantile(0.95), quantile(1), refused, damaged);
    }
};

RandomOptions options_of(std::uint64_t seed, RandomOptions options) {
    // One in 64 is large, the others have 12 passes on average.
    options.max_passes = seed % 64 == 63 ? 120 : 24;
    return options;
}

RandomSetting setting_of(std::uint64_t seed, const Arguments& arguments) {
    RandomSetting setting(seed);
    if (!arguments.options.queues) setting.capabilities.families.clear();
    return setting;
}

/// Whether an error text starts with "[code] ".
bool has_code(const char* text) {
    const char* const end = std::strchr(text, ']');
    return text[0] == '[' && end && end > text + 1 && end[1] == ' ';
}

/// One seed: empty if all went well, else what did not.
std::string run_valid(std::uint64_t seed, const Arguments& arguments, Figures& figures) {
    const RandomSetting setting = setting_of(seed, arguments);
    RandomDeclaration random(seed, options_of(seed, arguments.options), setting.capabilities);
    const Declaration& declaration = random.declaration();
    Plan plan;
    try {
        plan = compile(declaration, setting.capabilities, setting.policy);
    } catch (const Error& error) {
        return fmt::format("refused: {}", error.what());
    }
    if (arguments.verbose) fmt::print("{}", plan_text(declaration, plan));
    const Timer timer;
    const auto violations = verify(declaration, plan, setting.capabilities);
    figures.verify_us += 1e6 * timer.seconds();
    if (!violations.empty()) return violations_text(violations);
    const RandomDeclaration again(seed, options_of(seed, arguments.options), setting.capabilities);
    if (!(compile(again.declaration(), setting.capabilities, setting.policy) == plan))
        return "an equal declaration has another plan";
    if (plan.bytes_peak < plan.bytes_lower_bound && setting.policy.order == Order::declared)
        return fmt::format("{} bytes are less than the lower bound of {}", plan.bytes_peak,
            plan.bytes_lower_bound);
    ++figures.graphs;
    figures.steps += plan.steps.size();
    figures.barriers += plan.barriers.size();
    figures.several_queues += plan.queues.size() > 1;
    figures.compile_us += plan.compile_us;
    // What the packing decides: not whole pages of a granularity, nor memory of one range each.
    if (plan.bytes_lower_bound && setting.policy.alias_memory &&
        setting.capabilities.buffer_image_granularity == 1)
        figures.ratios.push_back(static_cast<float>(memory_ratio(plan)));
    return {};
}

std::string run_damaged(std::uint64_t seed, const Arguments& arguments, Figures& figures) {
    const RandomSetting setting = setting_of(seed, arguments);
    RandomDeclaration random(seed, options_of(seed, arguments.options), setting.capabilities);
    Declaration declaration = random.declaration();
    Corruption(seed, declaration);
    ++figures.damaged;
    try {
        const Plan plan = compile(declaration, setting.capabilities, setting.policy);
        const auto violations = verify(declaration, plan, setting.capabilities);
        if (!violations.empty()) return "damaged, but accepted:\n" + violations_text(violations);
    } catch (const Error& error) {
        if (arguments.verbose) fmt::print("refused: {}\n", error.what());
        ++figures.refused;
        if (!has_code(error.what())) return fmt::format("no code: {}", error.what());
    }
    return {};
}

/// Every fourth declaration is damaged.
std::string run(std::uint64_t seed, const Arguments& arguments, Figures& figures) {
    return seed % 4 == 3 ? run_damaged(seed, arguments, figures)
                         : run_valid(seed, arguments, figures);
}

int fuzz(const Arguments& arguments) {
    const Timer timer;
    std::atomic<std::uint64_t> next = arguments.first;
    std::atomic<bool> failed = false;
    const std::uint64_t end = arguments.first + arguments.count;
    Figures all;
    std::mutex mutex;
    const auto work = [&] {
        Figures figures;
        for (std::uint64_t seed = next++; seed < end && !failed; seed = next++) {
            const std::string problem = run(seed, arguments, figures);
            if (problem.empty()) continue;
            const std::scoped_lock lock(mutex);
            if (failed.exchange(true)) break;
            fmt::print("seed {}: {}\nrepeat it with: graph_fuzz --seed {} --verbose\n", seed,
                problem, seed);
        }
        const std::scoped_lock lock(mutex);
        all.add(figures);
    };
    std::vector<std::thread> threads;
    for (std::uint32_t i = 1; i < arguments.threads; ++i) threads.emplace_back(work);
    work();
    for (std::thread& thread : threads) thread.join();
    if (failed) return 1;
    const std::string text = all.text(timer.seconds());
    fmt::print("{}\n", text);
    if (arguments.figures.empty()) return 0;
    std::FILE* const file = std::fopen(arguments.figures.c_str(), "w");
    if (!file) {
        fmt::print("cannot write '{}'\n", arguments.figures);
        return 2;
    }
    fmt::print(file, "{}\n", text);
    std::fclose(file);
    return 0;
}

/// False if there is no such feature.
bool leave_out(const std::string& feature, RandomOptions& options) {
    if (feature == "parts")
        options.parts = false;
    else if (feature == "histories")
        options.histories = false;
    else if (feature == "guards")
        options.guards = false;
    else if (feature == "queues")
        options.queues = false;
    else
        return false;
    return true;
}

int main_of(int count, char** words) {
    Arguments arguments;
    for (int i = 1; i < count; ++i) {
        const std::string word = words[i];
        if (word == "--verbose") {
            arguments.verbose = true;
            continue;
        }
        if (i + 1 == count) {
            fmt::print("{}: unknown, or its value is missing; see graph_fuzz.cpp\n", word);
            return 2;
        }
        const char* const value = words[++i];
        const auto number = std::strtoull(value, nullptr, 10);
        if (word == "--seed") {
            arguments.first = number;
            arguments.count = arguments.threads = 1;
        } else if (word == "--first") {
            arguments.first = number;
        } else if (word == "--count") {
            arguments.count = number;
        } else if (word == "--threads") {
            arguments.threads = static_cast<std::uint32_t>(number);
        } else if (word == "--figures") {
            arguments.figures = value;
        } else if (word != "--without" || !leave_out(value, arguments.options)) {
            fmt::print("{} {}: unknown; see graph_fuzz.cpp\n", word, value);
            return 2;
        }
    }
    return fuzz(arguments);
}

} // namespace
} // namespace ockham

int main(int count, char** words) { return ockham::main_of(count, words); }

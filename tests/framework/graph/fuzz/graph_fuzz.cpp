// SPDX-License-Identifier: Apache-2.0
// Plans random declarations, for random devices, and verifies each plan; damaged declarations must
// be refused with a code or give a sound plan. Built with sanitizers.
//   graph_fuzz [--first N] [--count N] [--seed N] [--threads N] [--keep-going N] [--verbose]
//              [--without parts|histories|guards|queues]...
// --seed N does one, --verbose shows it. Exit code 1: the first failure (--keep-going: the first of
// each kind, until N have failed), and how to repeat it. Figures: $OCKHAM_FIGURES/graph_fuzz.txt
#include "framework/core/error.hpp"
#include "framework/core/timer.hpp"
#include "framework/graph/explain/dump.hpp"
#include "framework/graph/explain/explain.hpp"
#include "framework/graph/verify.hpp"
#include "tests/framework/graph/fuzz/corrupt.hpp"
#include "tests/framework/graph/random_declaration.hpp"

#include <algorithm>
#include <atomic>
#include <cctype>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

// Present where the program was linked with the sanitizers' runtimes.
extern "C" {
[[gnu::weak]] void __asan_init();
[[gnu::weak]] void __tsan_init();
[[gnu::weak]] void __ubsan_handle_out_of_bounds_abort(void* data, void* index);
[[gnu::weak]] void __sanitizer_set_death_callback(void (*callback)());
}

namespace ockham {
namespace {

/// "address, undefined"; "no" where there are none
std::string sanitizers() {
    std::string names;
    const auto add = [&](bool has, const char* name) {
        if (has) names += (names.empty() ? "" : ", ") + std::string(name);
    };
    add(__asan_init != nullptr, "address");
    add(__tsan_init != nullptr, "thread");
    add(__ubsan_handle_out_of_bounds_abort != nullptr, "undefined");
    return names.empty() ? "no" : names;
}

struct Arguments {
    std::uint64_t first = 0, count = 100000;
    std::uint64_t keep_going = 1; ///< failures after which to stop
    std::uint32_t threads = 2;
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
            "graph_fuzz: {} declarations in {:.1f} s ({:.0f} per s), all plans sound\n"
            "  {} damaged ones, {} refused, the others planned soundly\n"
            "  {} steps, {} barriers, {:.1f} % of the plans on several queues\n"
            "  heap / lower bound p50 {:.3f}, p95 {:.3f}, max {:.3f}\n"
            "  compile {:.0f} us, verify {:.0f} us each; sanitizers: {}\n",
            graphs + damaged, seconds, static_cast<double>(graphs + damaged) / seconds, damaged,
            refused, steps, barriers, 100 * per_graph(static_cast<double>(several_queues)),
            quantile(0.5), quantile(0.95), quantile(1), per_graph(compile_us), per_graph(verify_us),
            sanitizers());
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

std::string replay_options; ///< the features left out, as typed

std::string replay_command(std::uint64_t seed) {
    return fmt::format("graph_fuzz --seed {} --verbose{}", seed, replay_options);
}

thread_local std::uint64_t present_seed = 0; ///< that this thread works on

/// A sanitizer or a failed check() ends the process: says at which seed.
void say_seed() {
    fmt::print(stderr, "seed {} ended the program\nrepeat it with: {}\n", present_seed,
        replay_command(present_seed));
}

void say_seed_when_ended() {
    if (__sanitizer_set_death_callback) __sanitizer_set_death_callback(say_seed);
    for (const int signal : {SIGABRT, SIGTERM})
        std::signal(signal, [](int number) {
            say_seed();
            std::signal(number, SIG_DFL);
            std::raise(number);
        });
}

/// Failures by kind: messages without names and numbers.
class Failures {
public:
    explicit Failures(std::uint64_t limit) : limit_(limit) {}

    void add(std::uint64_t seed, const std::string& problem) {
        const std::scoped_lock lock(mutex_);
        Kind& kind = kinds_[kind_of(problem)];
        if (kind.count++ == 0 || seed < kind.seed) {
            kind.seed = seed;
            kind.text = problem;
        }
        ++count_;
    }
    bool are_enough() const { return count_ >= limit_; }
    bool empty() const { return kinds_.empty(); }

    void print() const {
        for (const auto& [_, kind] : kinds_)
            fmt::print("seed {}: {}\nrepeat it with: {}\n{}", kind.seed, kind.text,
                replay_command(kind.seed),
                kind.count > 1 ? fmt::format("({} seeds fail like this)\n", kind.count) : "");
        if (count_ > 1) fmt::print("{} failures of {} kinds\n", count_.load(), kinds_.size());
    }

private:
    struct Kind {
        std::uint64_t count = 0, seed = 0;
        std::string text;
    };

    /// The first line, names and numbers left out.
    static std::string kind_of(const std::string& problem) {
        std::string kind;
        bool is_name = false;
        const std::size_t start = problem.starts_with("damaged") ? problem.find('\n') + 1 : 0;
        for (const char c : problem.substr(start, problem.find('\n', start) - start)) {
            if (c == '\'') is_name = !is_name;
            if (!is_name && !std::isdigit(static_cast<unsigned char>(c))) kind += c;
        }
        return problem.substr(0, start) + kind;
    }

    std::uint64_t limit_;
    std::atomic<std::uint64_t> count_ = 0;
    std::mutex mutex_;
    std::map<std::string, Kind> kinds_;
};

/// To $OCKHAM_FIGURES/graph_fuzz.txt, if that is set.
void write_figures(const std::string& text) {
    const char* const folder = std::getenv("OCKHAM_FIGURES");
    if (!folder || !*folder) return;
    std::filesystem::create_directories(folder);
    const auto path = std::filesystem::path(folder) / "graph_fuzz.txt";
    std::ofstream file(path);
    file << text;
    file.close();
    if (!file) fail_input("cannot write '{}'", path.string());
}

int fuzz(const Arguments& arguments) {
    const Timer timer;
    std::atomic<std::uint64_t> next = arguments.first;
    const std::uint64_t end = arguments.first + arguments.count;
    Failures failures(arguments.keep_going);
    Figures all;
    std::mutex mutex;
    const auto work = [&] {
        Figures figures;
        for (std::uint64_t seed = next++; seed < end && !failures.are_enough(); seed = next++) {
            present_seed = seed;
            std::string problem;
            try {
                problem = run(seed, arguments, figures);
            } catch (const std::exception& error) {
                problem = fmt::format("threw: {}", error.what());
            }
            if (!problem.empty()) failures.add(seed, problem);
        }
        const std::scoped_lock lock(mutex);
        all.add(figures);
    };
    std::vector<std::thread> threads;
    for (std::uint32_t i = 1; i < arguments.threads; ++i) threads.emplace_back(work);
    work();
    for (std::thread& thread : threads) thread.join();
    failures.print();
    if (!failures.empty()) return 1;
    const std::string text = all.text(timer.seconds());
    fmt::print("{}", text);
    write_figures(text);
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
        } else if (word == "--keep-going") {
            arguments.keep_going = number;
        } else if (word == "--without" && leave_out(value, arguments.options)) {
            replay_options += " --without " + std::string(value);
        } else {
            fmt::print("{} {}: unknown; see graph_fuzz.cpp\n", word, value);
            return 2;
        }
    }
    say_seed_when_ended();
    try {
        return fuzz(arguments);
    } catch (const Error& error) {
        fmt::print("{}\n", error.what());
        return 2;
    }
}

} // namespace
} // namespace ockham

int main(int count, char** words) { return ockham::main_of(count, words); }

// SPDX-License-Identifier: Apache-2.0
// order_search: finds the sample orders of --order optimal and --order worst, and prints them as
// matrices of ranks with their errors. What it finds stands in passes/surface/sample_order.cpp.
#include "framework/app/cli.hpp"
#include "passes/surface/sample_order.hpp"
#include "samples/tools/order_search/search.hpp"

#include <fmt/format.h>

using namespace ockham;
using namespace ockham::order_search;

namespace {

/// Annealing for m > 4: more seeds or steps find little more.
constexpr std::uint64_t kSeeds = 4;
constexpr std::uint32_t kSteps = 4'000'000;

double sum_of_rms(const std::vector<CoverageError>& errors) {
    double sum = 0;
    for (const CoverageError& e : errors) sum += e.rms;
    return sum;
}

void print(const char* name, int m, const Judge& judge, const Order& order) {
    const std::vector<CoverageError> errors = judge.judge(order);
    double worst = 0;
    for (const CoverageError& e : errors) worst += e.worst;
    const double n = static_cast<double>(errors.size());
    fmt::print("m = {} {}: mean rms {:.4f}, mean worst {:.4f}\n  places {}\n", m, name,
        sum_of_rms(errors) / n, worst / n, fmt::join(order, ", "));
    Order ranks(order.size());
    for (std::uint32_t i = 0; i < order.size(); ++i) ranks[order[i]] = i;
    for (int y = 0; y < m; ++y) {
        fmt::print("  {:2}\n", fmt::join(ranks.begin() + y * m, ranks.begin() + (y + 1) * m, " "));
    }
}

Order annealed(int m, const Judge& judge) {
    std::vector<Order> bars{void_and_cluster(m)};
    if (m == 8) bars.push_back(sample_order(SampleOrder::paper, m));
    Order best;
    for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
        const Order found = anneal_order(judge, bars, seed, kSteps);
        if (best.empty() || sum_of_rms(judge.judge(found)) < sum_of_rms(judge.judge(best)))
            best = found;
    }
    return best;
}

} // namespace

int main() {
    return run_program([] {
        for (int m = 2; m <= 8; ++m) {
            const Judge judge(m);
            if (m <= 4) {
                print("optimal", m, judge, best_order(judge, Goal::rms));
                print("worst", m, judge, best_order(Judge(m, 360), Goal::worst));
            } else {
                print("optimal", m, judge, annealed(m, judge));
            }
        }
        return 0;
    });
}

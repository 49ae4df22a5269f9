// SPDX-License-Identifier: Apache-2.0
#include "passes/surface/budget.hpp"

#include "framework/core/error.hpp"
#include "framework/runtime/commands.hpp"
#include "passes/shader_variant.hpp"
#include "shaders/surface/budget.h"

#include <algorithm>
#include <cmath>

namespace ockham {
namespace {

constexpr std::uint32_t kShortestRun = 16, kMostRuns = 1u << 22; // a scan walks over 2^14 at most

shader::BudgetPush make_push(const ImageDesc& desc, const BudgetParams& params) {
    const double n = params.samples, floor = 100.0 / n;
    if (!(params.percent >= floor && params.percent <= 100.0)) {
        fail_input("budget of {} %: every pixel takes one of its {} samples, so at least {:.2f} %, "
                   "and at most 100 %",
            params.percent, params.samples, std::ceil(100.0 * floor) / 100.0);
    }
    const double pixels = double(desc.width) * desc.height;
    check(pixels * n < 4294967296.0, "samples are counted in 32 bits");
    const auto count = static_cast<std::uint32_t>(pixels);
    return {.size = {desc.width, desc.height},
        .samples = params.samples,
        .target = std::max(static_cast<std::uint32_t>(params.percent / 100.0 * pixels * n), count),
        .run = std::max(kShortestRun, (count + kMostRuns - 1) / kMostRuns)};
}

} // namespace

Allocation add_budget(Graph& graph, ImageHandle variance, const BudgetParams& params) {
    ImageDesc counts = graph.desc(variance);
    const shader::BudgetPush push = make_push(counts, params);
    counts.format = VK_FORMAT_R8_UINT;
    Allocation out{.sample_count = graph.create_image("sample_count", counts), .winner = {}};
    if (params.winner) out.winner = graph.create_image("winner", counts);
    const std::uint32_t runs = (counts.width * counts.height + push.run - 1) / push.run;

    BufferHandle bins =
        graph.create_buffer("budget_bins", {BUDGET_BINS * sizeof(shader::BudgetBin)});
    PassBuilder clear = graph.add_transfer_pass("budget_clear");
    clear.because("a histogram begins empty");
    bins = clear.copy_to(bins);
    clear.record([bins](Commands& commands) { commands.fill(bins, 0); });

    PassBuilder histogram = graph.add_compute_pass("budget_histogram");
    histogram.because(fmt::format("finds what {} % of all samples buy", params.percent));
    histogram.read("variance", variance);
    bins = histogram.read_write("budget_bins", bins);
    histogram.record([push](Commands& commands) {
        commands.dispatch_over({.shader = "surface/budget_histogram.comp",
                                   .specialization = {},
                                   .push = as_push(push)},
            {push.size.x, push.size.y, 1});
    });

    BufferHandle price = graph.create_buffer("budget_price", {sizeof(shader::BudgetPrice)});
    PassBuilder find = graph.add_compute_pass("budget_price");
    find.because("the lowest price of a sample that stays within the budget");
    find.read("budget_bins", bins);
    price = find.write("budget_price", price);
    find.record([push](Commands& commands) {
        commands.dispatch(
            {.shader = "surface/budget_price.comp", .specialization = {}, .push = as_push(push)},
            {1, 1, 1});
    });

    BufferHandle sums =
        graph.create_buffer("budget_runs", {std::uint64_t{runs} * sizeof(std::uint32_t)});
    PassBuilder count = graph.add_compute_pass("budget_count");
    count.because("who would take a sample at the next lower price");
    count.read("variance", variance).read("budget_price", price);
    sums = count.write("budget_runs", sums);
    count.record([push, runs](Commands& commands) {
        commands.dispatch_over(
            {.shader = "surface/budget_count.comp", .specialization = {}, .push = as_push(push)},
            {runs, 1, 1});
    });

    PassBuilder scan = graph.add_compute_pass("budget_scan");
    scan.because("what is left goes to the first of them");
    sums = scan.read_write("budget_runs", sums);
    scan.record([push](Commands& commands) {
        commands.dispatch(
            {.shader = "surface/budget_scan.comp", .specialization = {}, .push = as_push(push)},
            {1, 1, 1});
    });

    PassBuilder spend = graph.add_compute_pass("budget");
    spend.because(fmt::format("{} % of all samples, to whom they help most", params.percent));
    spend.read("variance", variance).read("budget_price", price).read("budget_runs", sums);
    out.sample_count = spend.write("sample_count", out.sample_count);
    if (params.winner) out.winner = spend.write("winner", out.winner);
    spend.record([push, runs, winner = params.winner](Commands& commands) {
        const std::string shader = shader_variant("surface/budget.comp", {{"winner", winner}});
        commands.dispatch_over(
            {.shader = shader, .specialization = {}, .push = as_push(push)}, {runs, 1, 1});
    });
    return out;
}

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/explain/budget.hpp"

#include "framework/graph/explain/dump.hpp"
#include "framework/graph/explain/json_reader.hpp"
#include "framework/graph/explain/words.hpp"

namespace ockham {

namespace {

std::string largest_resources(const JsonReader& plan) {
    constexpr std::size_t shown = 10;
    std::vector<JsonReader> all = plan["resources"].items();
    std::stable_sort(all.begin(), all.end(), [](const JsonReader& a, const JsonReader& b) {
        return a["bytes"].number() > b["bytes"].number();
    });
    std::string text;
    for (std::size_t i = 0; i < std::min(shown, all.size()) && all[i]["bytes"].number(); ++i)
        text += fmt::format("  {:>10}  '{}' {}\n", size_text(all[i]["bytes"].number()),
            all[i]["name"].text(), all[i]["reason"].text());
    return text;
}

} // namespace

std::string over_budget(const Declaration& declaration, const Plan& plan, const Budget& budget) {
    return over_budget(plan_json(declaration, plan), budget);
}

std::string over_budget(const nlohmann::json& plan, const Budget& budget) {
    const JsonReader in(plan, "bad-plan-file");
    std::string text;
    const auto limit = [&](const char* what, std::optional<std::uint64_t> most, auto count) {
        if (!most) return;
        const std::uint64_t found = count();
        if (found > *most)
            text += fmt::format(
                "{} {}, {} above the budget of {}\n", found, what, found - *most, *most);
    };
    limit("passes", budget.passes, [&] {
        const std::vector<JsonReader> all = in["passes"].items();
        return static_cast<std::uint64_t>(std::count_if(
            all.begin(), all.end(), [](const JsonReader& one) { return !one["culled"].yes(); }));
    });
    limit("barriers", budget.barriers, [&] { return in["barriers"].items().size(); });
    limit("batches", budget.batches, [&] { return in["memory"]["batches"].number(); });
    limit("submissions", budget.submissions, [&] { return in["submissions"].items().size(); });
    if (budget.bytes) {
        const std::uint64_t bytes = in["memory"]["bytes_peak"].number();
        if (bytes > *budget.bytes)
            text += fmt::format("{}, {} above the budget of {}; the largest:\n{}", size_text(bytes),
                size_text(bytes - *budget.bytes), size_text(*budget.bytes), largest_resources(in));
    }
    return text;
}

} // namespace ockham

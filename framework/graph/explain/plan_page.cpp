// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/explain/plan_page.hpp"

#include "framework/core/error.hpp"
#include "framework/graph/explain/dump.hpp"
#include "framework/graph/explain/timeline.hpp"
#include "framework/graph/explain/words.hpp"

#include <nlohmann/json.hpp>

#include <cmath>

namespace ockham {

extern const char* const kPlanPage; // plan_page.html, embedded by CMake

namespace {

using nlohmann::json;

json uses_json(const Declaration& declaration, PassId pass) {
    json out = json::array();
    for (const Use& use : declaration.uses_of(pass)) {
        out.push_back({{"resource", use.resource}, {"access", name_of(use.access)},
            {"reads", needs_content(use)}, {"writes", writes(use.access)}});
        const std::string part =
            part_text(declaration.resources[use.resource], part_of(declaration, use));
        if (!part.empty()) out.back()["part"] = part;
    }
    return out;
}

/// Starts and durations of the steps: measured, and as if all took the same time.
json times_json(const Plan& plan, std::span<const double> milliseconds) {
    const std::vector<double> ones(plan.steps.size(), 1.0);
    json out{{"unit", start_times(plan, ones)}, {"start", json::array()}, {"ms", json::array()}};
    if (milliseconds.empty()) return out;
    std::vector<double> durations(milliseconds.begin(), milliseconds.end());
    for (double& one : durations) one = std::isfinite(one) ? one : 0.0;
    out["start"] = start_times(plan, durations);
    for (const double one : milliseconds)
        out["ms"].push_back(std::isfinite(one) ? json(one) : json());
    return out;
}

/// JSON that may stand in an HTML script element, whatever names are in it.
std::string embedded(const json& value) {
    std::string text;
    for (const char c : value.dump(-1, ' ', false, json::error_handler_t::replace)) {
        if (c == '<')
            text += "\\u003c"; // neither </script> nor <!-- ends the element
        else
            text += c;
    }
    return text;
}

} // namespace

std::string plan_html(
    const Declaration& declaration, const Plan& plan, std::span<const double> milliseconds) {
    check(milliseconds.empty() || milliseconds.size() == plan.steps.size(), "one time per step");
    json data = plan_json(declaration, plan);
    for (const char* key : {"declaration", "capabilities", "policy"}) data.erase(key);
    for (PassId pass = 0; pass < declaration.passes.size(); ++pass)
        data["passes"][pass]["uses"] = uses_json(declaration, pass);
    data["name"] = declaration.name;
    data["times"] = times_json(plan, milliseconds);

    std::string page = kPlanPage;
    constexpr std::string_view place = "@plan@";
    page.replace(page.find(place), place.size(), embedded(data));
    return page;
}

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
// Compact lines of a plan, for tests that compare plans with expected text.
#pragma once

#include "framework/graph/compile.hpp"
#include "framework/graph/explain/dump.hpp"
#include "framework/graph/graph.hpp"

#include <nlohmann/json.hpp>

#include <string>

namespace ockham {

/// "a b c": names of the passes that are executed, in order.
inline std::string order_line(const Declaration& declaration, const Plan& plan) {
    std::string line;
    for (const Step& step : plan.steps)
        line += (line.empty() ? "" : " ") + declaration.passes[step.pass].name;
    return line;
}

/// One line a barrier: "to <- from: resource hazard | src stages/access -> dst stages/access |
/// layouts".
inline std::string barrier_lines(const Declaration& declaration, const Plan& plan) {
    std::string lines;
    const nlohmann::json json = plan_json(declaration, plan);
    for (const auto& b : json["barriers"]) {
        const auto text = [&](const char* key) { return b[key].get<std::string>(); };
        lines += text("to") + " <- " + text("from") + ": " + text("resource") + " " +
                 text("hazard") + " | " + text("src_stages") + "/" + text("src_access") + " -> " +
                 text("dst_stages") + "/" + text("dst_access");
        if (b.contains("old_layout"))
            lines += " | " + text("old_layout") + " -> " + text("new_layout");
        lines += "\n";
    }
    return lines;
}

inline std::string barrier_lines(const Graph& graph) {
    return barrier_lines(graph.declaration(), compile(graph.declaration()));
}

inline const ImageDesc kColor{VK_FORMAT_R32_SFLOAT, 64, 64};
inline const ImageDesc kDepth{VK_FORMAT_D32_SFLOAT, 64, 64};

} // namespace ockham

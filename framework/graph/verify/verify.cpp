// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/verify.hpp"

#include "framework/graph/verify/verify_model.hpp"

namespace ockham {

const char* name_of(Violation::Kind kind) {
    constexpr const char* names[] = {"malformed", "order", "culling", "submission", "execution",
        "memory", "layout", "content", "ownership", "placement", "alias", "usage"};
    return names[static_cast<std::size_t>(kind)];
}

std::vector<Violation> verify(
    const Declaration& declaration, const Plan& plan, const Capabilities& capabilities) {
    std::vector<Violation> violations;
    verifier::Report report(declaration, violations);
    if (!verifier::check_shape(declaration, plan, capabilities, report)) return violations;
    const verifier::Grids grids(declaration, plan);
    verifier::check_submissions(declaration, plan, capabilities, report);
    if (!violations.empty()) return violations;
    verifier::check_order(declaration, plan, grids, report);
    verifier::check_culling(declaration, plan, grids, report);
    verifier::check_placements(declaration, plan, report);
    verifier::check_execution(declaration, plan, capabilities, grids, report);
    return violations;
}

std::string violations_text(const std::vector<Violation>& violations) {
    std::string text;
    for (const Violation& violation : violations) {
        text += '[';
        text += name_of(violation.kind);
        text += "] ";
        text += violation.text;
        text += '\n';
    }
    return text;
}

} // namespace ockham

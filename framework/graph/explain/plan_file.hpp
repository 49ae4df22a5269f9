// SPDX-License-Identifier: Apache-2.0
// Declarations, capabilities and policies as JSON and back, without loss, so that a plan can be
// made again elsewhere. What is loaded may be anybody's: it is checked before it reaches compile().
#pragma once

#include "framework/graph/compile.hpp"

#include <nlohmann/json_fwd.hpp>

namespace ockham {

/// Everything that decides a plan, and its words. Left out: recording functions and source lines
/// (written as text for people, not read again).
nlohmann::json declaration_json(const Declaration& declaration);
nlohmann::json to_json(const Capabilities& capabilities);
nlohmann::json to_json(const Policy& policy);

/// What declaration_json() wrote, or somebody by hand. Throws Error(input) whose text starts with
/// "[bad-plan-file]" and names the place by its JSON pointer, for what is missing, of another type,
/// out of range, or refers to what is not there. Mistakes that compile() finds are left to it.
Declaration load_declaration(const nlohmann::json& json);

/// A file of plan_json(), as much of it as compile() needs. Missing capabilities and policy are the
/// defaults.
struct PlanFile {
    Declaration declaration;
    Capabilities capabilities;
    Policy policy;
};
/// Throws like load_declaration().
PlanFile load_plan_file(const nlohmann::json& json);

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
// A plan as text for people, DOT for graphviz, JSON for programs. explain.hpp has the reasons.
// Pure functions from plain data to strings.
#pragma once

#include "framework/graph/plan.hpp"

#include <nlohmann/json_fwd.hpp>

#include <string>

namespace ockham {

/// A table of steps with their barriers, then resources with their memory, then what was culled.
std::string plan_text(const Declaration& declaration, const Plan& plan);
/// Passes as boxes, resources as ellipses, culled ones dashed.
std::string plan_dot(const Declaration& declaration, const Plan& plan);
/// {passes:[{name,kind,culled,reason}], resources:[{name,kind,lifetime,bytes,culled,reason}],
///  barriers:[{resource,hazard,from,to,src_stages,...}], memory:{...}}. Omissions are listed as
/// culled passes or resources.
nlohmann::json plan_json(const Declaration& declaration, const Plan& plan);

} // namespace ockham

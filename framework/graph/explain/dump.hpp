// SPDX-License-Identifier: Apache-2.0
// A plan as text for people, DOT for graphviz, JSON for programs. explain.hpp has the reasons,
// plan_page.hpp a page to look at, plan_file.hpp reads the JSON again. Pure functions from plain
// data.
#pragma once

#include "framework/graph/compile.hpp"
#include "framework/graph/plan.hpp"

#include <nlohmann/json_fwd.hpp>

#include <string>

namespace ockham {

/// A table of steps with their barriers, then submissions where there are several queues, resources
/// with their memory, and what was culled.
std::string plan_text(const Declaration& declaration, const Plan& plan);
/// Passes as boxes, resources as ellipses, culled ones dashed.
std::string plan_dot(const Declaration& declaration, const Plan& plan);

/// The plan with all its reasons, and what it was made from, so that it can be made again
/// (plan_file.hpp): docs/formats.md lists the keys. Omissions are listed as culled passes or
/// resources. `capabilities` and `policy` are those that the plan was compiled with.
nlohmann::json plan_json(const Declaration& declaration, const Plan& plan,
    const Capabilities& capabilities = {}, const Policy& policy = {});

} // namespace ockham

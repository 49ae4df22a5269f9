// SPDX-License-Identifier: Apache-2.0
// Limits that a plan must keep: for tests that want to notice when a pipeline grows, and for
// plan_diff. Policy::memory_budget_bytes is another thing: what a device may spend.
#pragma once

#include "framework/graph/plan.hpp"

#include <nlohmann/json_fwd.hpp>

#include <optional>
#include <string>

namespace ockham {

/// Largest allowed numbers; empty: any.
struct Budget {
    std::optional<std::uint64_t> passes = {}; ///< that are executed
    std::optional<std::uint64_t> barriers = {};
    std::optional<std::uint64_t> batches = {};
    std::optional<std::uint64_t> submissions = {};
    std::optional<std::uint64_t> bytes = {}; ///< of all heaps
};

/// Empty where the plan keeps the budget. Else a line for each number that is too large, and where
/// bytes are, the largest resources with the reasons why they live.
std::string over_budget(const Declaration& declaration, const Plan& plan, const Budget& budget);
/// The same for what plan_json() returned, perhaps in an older version. Throws Error(input) where a
/// number that the budget limits is not in it.
std::string over_budget(const nlohmann::json& plan, const Budget& budget);

} // namespace ockham

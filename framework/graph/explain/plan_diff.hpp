// SPDX-License-Identifier: Apache-2.0
// What changed from one plan to another, both as JSON of plan_json(). Names are what is compared:
// order and indices may differ freely. For the program plan_diff and for tests.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include <string>

namespace ockham {

/// {numbers: {passes: {before, after}, barriers, batches, submissions, queues, bytes_peak,
///   bytes_lower_bound},
///  passes: {added, removed, culled, revived, moved: [{name, reason}]},
///  resources: {added, removed, resized: [{name, before, after}]},
///  barriers: {added, removed: [{text, reason, count}]}}
/// Numbers of bytes are those of memory. Throws Error(input) starting with "[bad-plan-file]" for
/// what is no plan.
nlohmann::json plan_diff(const nlohmann::json& before, const nlohmann::json& after);
/// The same for people: "+3 barriers, +12.0 MiB", then what changed, a line each. "no difference"
/// where there is none.
std::string plan_diff_text(const nlohmann::json& diff);

} // namespace ockham

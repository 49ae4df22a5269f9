// SPDX-License-Identifier: Apache-2.0
// The decisions of a plan in sentences: why a pass or resource is kept or culled, why a barrier
// exists. Derived from declaration and plan when asked, so that planning builds no text.
#pragma once

#include "framework/graph/plan.hpp"

#include <string>

namespace ockham {

/// "kept: 'blur' reads its 'color'; the user asked for softness"
std::string reason_of_pass(const Declaration& declaration, const Plan& plan, PassId pass);
/// "kept: used from 'draw' to 'blur'; exported (the picture)"
std::string reason_of_resource(const Declaration& declaration, const Plan& plan, ResourceId id);
/// "'blur' reads 'color' as 'draw' left it"
std::string reason_of_barrier(const Declaration& declaration, const Barrier& barrier);

/// "graph 'g': 3 of 4 passes, 5 barriers in 2 batches, 45.3 MiB (lower bound 45.3 MiB,
/// ratio 1.000)"
std::string summary(const Declaration& declaration, const Plan& plan);
/// Heap bytes per byte of the lower bound, >= 1; 1 where there are none.
double memory_ratio(const Plan& plan);
/// One line for each pass and resource that was culled or left out, with its reason.
std::string absences(const Declaration& declaration, const Plan& plan);

/// All of it, in execution order: steps with their barriers, resources, and what is not there.
std::string explain(const Declaration& declaration, const Plan& plan);

} // namespace ockham

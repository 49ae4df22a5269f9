// SPDX-License-Identifier: Apache-2.0
// The decisions of a plan in sentences: why a pass or resource is kept or culled, runs after
// another, waits, or has memory of its own. Derived from declaration and plan when asked, so that
// planning builds no text.
#pragma once

#include "framework/graph/explain/dependencies.hpp"
#include "framework/graph/plan.hpp"

#include <span>
#include <string>

namespace ockham {

/// "kept: 'blur' reads its 'color'; only where 'soft'; the user asked for softness"
std::string reason_of_pass(const Declaration& declaration, const Plan& plan, PassId pass);
/// "kept: used from 'draw' to 'blur'; exported (the picture)"
std::string reason_of_resource(const Declaration& declaration, const Plan& plan, ResourceId id);
/// "'draw' writes 'color' and mip 1 of 'z' for 'blur' to read": why a pass runs after another. All
/// of `dependencies`, at least one, are of one pair of passes.
std::string reason_of_order(
    const Declaration& declaration, std::span<const Dependency> dependencies);
/// "'blur' reads 'color' as 'draw' left it". `barrier` must be one of the plan's.
std::string reason_of_barrier(
    const Declaration& declaration, const Plan& plan, const Barrier& barrier);
/// "for the main queue: 'draw' writes 'color' for 'blur' to read". `wait` is one of those
/// of `submission`, both of the plan; `direct` are its direct_dependencies().
std::string reason_of_wait(const Declaration& declaration, const Plan& plan,
    std::span<const Dependency> direct, const Submission& submission, const Wait& wait);
/// Why two resources have no byte of memory in common, or which they have.
std::string why_not_shared(
    const Declaration& declaration, const Plan& plan, ResourceId a, ResourceId b);

/// The step at which most bytes live, and what lives there, largest first. What is kept between
/// executions (persistent, exported) lives in every step.
struct Peak {
    std::uint32_t step = 0;
    std::uint64_t bytes = 0;
    std::vector<ResourceId> live;
};
Peak memory_peak(const Plan& plan);
/// For the end of an error about memory: "\ngraph 'g' needs 4.000 MiB, ...", and core's
/// memory_table() of what lies in the plan's heaps and why.
std::string needs_text(const Declaration& declaration, const Plan& plan);

/// "the main queue" or "queue 1".
std::string queue_text(std::uint32_t queue);
/// "graph 'g': 3 of 4 passes, 5 barriers in 2 batches, 45.3 MiB (lower bound 45.3 MiB,
/// ratio 1.000)"; where there are several queues, also these and their submissions.
std::string summary(const Declaration& declaration, const Plan& plan);
/// Heap bytes per byte of the lower bound, >= 1; 1 where there are none.
double memory_ratio(const Plan& plan);
/// One line for each pass and resource that was culled or left out, with its reason.
std::string absences(const Declaration& declaration, const Plan& plan);

/// All of it, in execution order: steps with what they wait for, resources, memory, and what is not
/// there.
std::string explain(const Declaration& declaration, const Plan& plan);

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
// When each step of a plan runs, given how long each takes: queues side by side, held up by their
// waits. A model for pictures and traces, not a measurement.
#pragma once

#include "framework/graph/plan.hpp"

#include <span>
#include <vector>

namespace ockham {

/// Start of each step, in the unit of `durations` (one per step), from 0. A queue runs its steps
/// one after the other, and a submission starts once all that it waits for has ended.
std::vector<double> start_times(const Plan& plan, std::span<const double> durations);

/// For each step the queue that runs it: index into Plan::queues.
std::vector<std::uint32_t> queue_of_steps(const Plan& plan);

/// Index into Plan::submissions of the submission that makes `queue`'s timeline reach `value`;
/// kNone if there is none.
std::uint32_t submission_of(const Plan& plan, std::uint32_t queue, std::uint32_t value);

} // namespace ockham

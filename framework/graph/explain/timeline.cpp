// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/explain/timeline.hpp"

#include "framework/core/error.hpp"

#include <algorithm>

namespace ockham {

std::vector<double> start_times(const Plan& plan, std::span<const double> durations) {
    check(durations.size() == plan.steps.size(), "one duration per step");
    std::vector<double> starts(plan.steps.size(), 0.0);
    std::vector<double> free(plan.queues.size(), 0.0); // when each queue has done all so far
    std::vector<double> ends;                          // of the submissions so far
    for (const Submission& submission : plan.submissions) {
        double now = free[submission.queue];
        for (std::uint32_t i = 0; i < submission.wait_count; ++i) {
            const Wait& wait = plan.waits[submission.first_wait + i];
            const std::uint32_t awaited = submission_of(plan, wait.queue, wait.value);
            if (awaited < ends.size()) now = std::max(now, ends[awaited]);
        }
        for (std::uint32_t i = 0; i < submission.step_count; ++i) {
            starts[submission.first_step + i] = now;
            now += durations[submission.first_step + i];
        }
        free[submission.queue] = now;
        ends.push_back(now);
    }
    return starts;
}

std::vector<std::uint32_t> queue_of_steps(const Plan& plan) {
    std::vector<std::uint32_t> queues(plan.steps.size(), 0);
    for (const Submission& submission : plan.submissions)
        std::fill_n(
            queues.begin() + submission.first_step, submission.step_count, submission.queue);
    return queues;
}

std::uint32_t submission_of(const Plan& plan, std::uint32_t queue, std::uint32_t value) {
    for (std::uint32_t i = 0; i < plan.submissions.size(); ++i)
        if (plan.submissions[i].queue == queue && --value == 0) return i;
    return kNone;
}

} // namespace ockham

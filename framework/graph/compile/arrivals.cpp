// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/compile/arrivals.hpp"

#include <algorithm>
#include <limits>

namespace ockham {

namespace {

constexpr Time kNever = std::numeric_limits<Time>::min() / 2;

/// a = max(a, b), element by element.
void join(Time* a, const Time* b, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) a[i] = std::max(a[i], b[i]);
}

} // namespace

Arrivals::Arrivals(const Plan& plan)
    : queues_(std::max(static_cast<std::uint32_t>(plan.queues.size()), 1u)) {
    if (queues_ == 1) return;
    // Before the first execution nothing was done; the second round knows how the first ended.
    entry_.assign(std::size_t{queues_} * queues_, kNever);
    for (int round = 0; round < 2; ++round) add_round(plan);
}

void Arrivals::add_round(const Plan& plan) {
    ends_.assign(plan.submissions.size() * queues_, kNever);
    stages_.assign(plan.submissions.size(), VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT);
    std::vector<std::vector<std::uint32_t>> done(queues_); // submissions of each queue
    for (std::uint32_t i = 0; i < plan.submissions.size(); ++i) {
        const Submission& submission = plan.submissions[i];
        std::vector<std::uint32_t>& own = done[submission.queue];
        Time* const ends = &ends_[i * queues_];
        if (own.empty()) {
            join(ends, &entry_[submission.queue * queues_], queues_);
            for (std::uint32_t q = 0; q < queues_; ++q)
                if (q != submission.queue) ends[q] = std::max(ends[q], Time{0});
        } else {
            join(ends, &ends_[own.back() * queues_], queues_);
            stages_[i] = stages_[own.back()];
        }
        for (std::uint32_t w = 0; w < submission.wait_count; ++w) {
            const Wait& wait = plan.waits[submission.first_wait + w];
            const std::uint32_t other = done[wait.queue][wait.value - 1];
            const Submission& waited = plan.submissions[other];
            join(ends, &ends_[other * queues_], queues_);
            ends[wait.queue] =
                std::max(ends[wait.queue], time_of(waited.first_step + waited.step_count));
            if (wait.stages != VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT)
                stages_[i] = stages_[i] == VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT
                                 ? wait.stages
                                 : stages_[i] & wait.stages;
        }
        own.push_back(i);
    }
    // Each queue begins the next execution with what the last submissions of the others knew.
    const Time period = period_of(plan);
    for (std::uint32_t q = 0; q < queues_; ++q)
        for (std::uint32_t other = 0; other < queues_; ++other) {
            if (other == q || done[other].empty()) continue;
            const Time* const ends = &ends_[done[other].back() * queues_];
            for (std::uint32_t k = 0; k < queues_; ++k)
                entry_[q * queues_ + k] = std::max(entry_[q * queues_ + k], ends[k] - period);
        }
}

} // namespace ockham

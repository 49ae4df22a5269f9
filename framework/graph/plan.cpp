// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/plan.hpp"

#include <algorithm>
#include <array>
#include <tuple>

namespace ockham {

const char* name_of(Hazard hazard) {
    constexpr std::array<const char*, 9> names{"read_after_write", "write_after_read",
        "write_after_write", "layout", "first_use", "alias", "exit", "release", "acquire"};
    return names[static_cast<std::size_t>(hazard)];
}

std::uint32_t Plan::batches() const {
    const auto with = std::count_if(
        steps.begin(), steps.end(), [](const Step& step) { return step.barrier_count != 0; });
    return static_cast<std::uint32_t>(with) + (exit_barrier_count != 0);
}

bool operator==(const Plan& a, const Plan& b) {
    const auto tie = [](const Plan& p) {
        return std::tie(p.queues, p.submissions, p.waits, p.steps, p.barriers, p.first_exit_barrier,
            p.exit_barrier_count, p.placements, p.heaps, p.passes, p.resources, p.final_states,
            p.usages, p.concurrent, p.bytes_peak, p.bytes_lower_bound);
    };
    return tie(a) == tie(b);
}

} // namespace ockham

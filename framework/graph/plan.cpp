// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/plan.hpp"

#include <algorithm>
#include <array>

namespace ockham {

const char* name_of(Hazard hazard) {
    constexpr std::array<const char*, 7> names{"read_after_write", "write_after_read",
        "write_after_write", "layout", "first_use", "alias", "exit"};
    return names[static_cast<std::size_t>(hazard)];
}

std::uint32_t Plan::batches() const {
    const auto with = std::count_if(
        steps.begin(), steps.end(), [](const Step& step) { return step.barrier_count != 0; });
    return static_cast<std::uint32_t>(with) + (exit_barrier_count != 0);
}

} // namespace ockham

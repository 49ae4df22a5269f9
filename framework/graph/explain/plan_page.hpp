// SPDX-License-Identifier: Apache-2.0
// A plan as one HTML page to look at: queues, lifetimes, barriers and memory over time, and the
// reason of each. Self-contained: needs no network. The page itself is plan_page.html.
#pragma once

#include "framework/graph/plan.hpp"

#include <span>
#include <string>

namespace ockham {

/// `milliseconds`: GPU time of each step, NaN for one that was skipped; none where nothing was
/// measured, and then every step is equally long.
std::string plan_html(
    const Declaration& declaration, const Plan& plan, std::span<const double> milliseconds = {});

} // namespace ockham

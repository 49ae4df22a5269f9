// SPDX-License-Identifier: Apache-2.0
// Both papers' tables and figures, as far as they are measurements or pictures, on the scenes and
// volumes at hand, with the papers' own numbers in columns of their own. Called by chart.
#pragma once

#include "samples/chart/suite.hpp"

namespace ockham::chart {

std::unique_ptr<Suite> make_papers_suite(Context& context);

} // namespace ockham::chart

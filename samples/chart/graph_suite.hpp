// SPDX-License-Identifier: Apache-2.0
// Charts of the render graph: what planning costs against the number of passes, and how near heaps
// come to their lower bound. Needs no device. Called by main.cpp.
#pragma once

#include "samples/chart/suite.hpp"

namespace ockham::chart {

std::unique_ptr<Suite> make_graph_suite(Context& context);

} // namespace ockham::chart

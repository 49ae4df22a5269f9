// SPDX-License-Identifier: Apache-2.0
// What theory says of curves, and what they do: errors that fall as the root of the samples, counts
// that no change of scale touches, caches that grow exact with their cells, windows that grow exact
// with m. Called by chart.
#pragma once

#include "samples/chart/suite.hpp"

namespace ockham::chart {

std::unique_ptr<Suite> make_stability_suite(Context& context);

} // namespace ockham::chart

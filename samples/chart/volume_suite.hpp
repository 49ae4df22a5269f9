// SPDX-License-Identifier: Apache-2.0
// Charts of volumes: error over time for every mode, shading model, cache and estimator, what a
// cache's bytes buy, and what the searches for isosurfaces cost. Called by chart.
#pragma once

#include "samples/chart/suite.hpp"

namespace ockham::chart {

std::unique_ptr<Suite> make_volume_suite(Context& context);

} // namespace ockham::chart

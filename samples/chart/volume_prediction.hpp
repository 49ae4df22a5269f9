// SPDX-License-Identifier: Apache-2.0
// What suite volume has measured, as classes to choose by, and how good such choices are. Measures
// nothing. Called by volume_suite.
#pragma once

#include "samples/chart/volume_choice.hpp"
#include "samples/chart/volume_runs.hpp"

namespace ockham::chart {

/// A class of each scene whose path tracing reached the steps of a probe.
VolumeChart volume_chart_of(const std::vector<Point>& points,
    const std::vector<VolumeScene>& scenes, const std::string& device);

/// Error and time asked for against those obtained: each class is chosen for by the others of the
/// program's chart. None where there are no classes.
std::vector<Plot> volume_prediction_plots(const VolumeChart& measured);

} // namespace ockham::chart

// SPDX-License-Identifier: Apache-2.0
// Charts of anti-aliasing: every method over its knob, error against GPU time and samples, with
// cheap and with stalled shading; what each way to dispatch makes of saved samples; the limits that
// the full reference sets. Called by main.cpp.
#pragma once

#include "samples/chart/aa_choice.hpp"
#include "samples/chart/suite.hpp"

namespace ockham::chart {

/// Dependent multiply-adds per shaded sample where shading is stalled.
inline constexpr std::uint32_t kAaStall = 2000;

/// The setting of a series that pictures and tables show: its default, or the one it has.
std::string shown_setting(const std::string& series);

std::unique_ptr<Suite> make_aa_suite(Context& context);

/// The curves of the default metric, one class for each scene: what adaptive_aa chooses by.
AaChart aa_chart_of(const std::vector<Point>& points, const std::vector<std::string>& scenes,
    const std::string& device);

/// What the page shows of the measurements of `scenes`, labels of jobs; aa_report.cpp.
Section aa_report(const Context& context, const Store& store, const std::vector<Point>& points,
    const std::vector<std::string>& scenes);

} // namespace ockham::chart

// SPDX-License-Identifier: Apache-2.0
// Points of charts that hold what a choice was asked for against what it gets, and the line where
// both are equal. Called by aa_report and volume_prediction.
#pragma once

#include "samples/chart/plot.hpp"

#include <algorithm>

namespace ockham::chart {

inline PlotPoint obtained(double asked, double got, std::string setting = {}) {
    return {.x = {asked, asked, asked},
        .y = {got, got, got},
        .setting = std::move(setting),
        .command = {},
        .x_values = {asked},
        .y_values = {got}};
}

/// Over all that the plot's curves were asked for.
inline Curve as_asked(const Plot& plot) {
    Curve curve{.legend = "as asked", .kind = Curve::Kind::limit};
    for (const Curve& one : plot.curves)
        for (const PlotPoint& point : one.points)
            curve.points.push_back(obtained(point.x.median, point.x.median));
    std::sort(curve.points.begin(), curve.points.end(),
        [](const PlotPoint& a, const PlotPoint& b) { return a.x.median < b.x.median; });
    return curve;
}

} // namespace ockham::chart

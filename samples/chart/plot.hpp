// SPDX-License-Identifier: Apache-2.0
// One chart: curves over two quantities with error bars, the front of what nothing else beats, and
// marks. Drawn by gnuplot as SVG; every number on it is a row of a CSV. Filled by suites.
#pragma once

#include "samples/chart/store.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace ockham::chart {

enum class Better { neither, less, more };

/// `value` names what Point::values holds; "knob": the knob.
struct Axis {
    std::string value;
    std::string label; ///< with its unit: "GPU time (ms)"
    bool logarithmic = false;
    Better better = Better::neither; ///< both axes' say: a Pareto front is drawn
    std::optional<double> most{};    ///< the axis ends there; what lies beyond is in the CSV alone
};

struct PlotPoint {
    Spread x, y;
    std::string setting{}; ///< for the table: "1e-05"
    std::string command{};
    std::vector<double> x_values{}, y_values{}; ///< of the repeats
};

struct Curve {
    enum class Kind {
        line,  ///< points joined in their order
        dots,  ///< points alone
        limit, ///< a line without points: what no method can pass, or what a paper reports
    };
    std::string legend;
    Kind kind = Kind::line;
    std::vector<PlotPoint> points{};
    /// May be on the Pareto front; limits never are.
    bool competes = true;
};

/// A star where a target would set the knob; with x or y alone, a line across the whole chart.
struct Mark {
    std::string label;
    std::optional<double> x{}, y{};
};

struct Plot {
    std::string name;     ///< stem of its files: lower case, digits, '_'
    std::string question; ///< its title
    Axis x, y;
    std::vector<Curve> curves{};
    std::vector<Mark> marks{};
    std::string caption{}; ///< HTML under it: how to read it
};

/// The points of `series` on `scene` that have both values of the axes, as a curve.
Curve curve(const std::vector<Point>& points, const std::string& scene, const std::string& series,
    const Plot& plot, std::string legend, Curve::Kind kind = Curve::Kind::line);

/// Of those that compete: medians that no other matches in one axis and beats in the other, by
/// rising x. Empty unless both axes say what is better.
std::vector<PlotPoint> pareto_front(const Plot& plot);

/// A heading and a row for each point: series, setting, median and reach of x and y, the repeats'
/// values, whether it is on the front, command. Marks come last, with "mark" for a setting.
std::string csv(const Plot& plot);
/// A text as a Plot::name: lower case, digits and '_'.
std::string stem_of(const std::string& text);
/// A text as a cell of CSV: quoted where it must be.
std::string csv_cell(const std::string& text);
/// What gnuplot draws `svg` from.
std::string gnuplot_script(const Plot& plot, const std::filesystem::path& svg);

bool gnuplot_is_installed();
/// Runs it. Throws Error(input) where it fails.
void draw(const Plot& plot, const std::filesystem::path& svg);

} // namespace ockham::chart

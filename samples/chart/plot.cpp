// SPDX-License-Identifier: Apache-2.0
#include "samples/chart/plot.hpp"

#include "framework/core/error.hpp"
#include "framework/core/file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace ockham::chart {
namespace {

std::optional<Spread> value_of(const Point& point, const Axis& axis, std::vector<double>& values) {
    if (axis.value == "knob") {
        values = {point.knob};
    } else {
        if (!point.has(axis.value)) return std::nullopt;
        values = point.values.at(axis.value);
    }
    return spread(values);
}

bool beats(double a, double b, Better better) { return better == Better::less ? a < b : a > b; }

/// `a` is nowhere worse than `b`, and somewhere better.
bool dominates(const Plot& plot, const PlotPoint& a, const PlotPoint& b) {
    const double ax = a.x.median, bx = b.x.median, ay = a.y.median, by = b.y.median;
    return !beats(bx, ax, plot.x.better) && !beats(by, ay, plot.y.better) &&
           (beats(ax, bx, plot.x.better) || beats(ay, by, plot.y.better));
}

std::string joined(const std::vector<double>& values) {
    return fmt::format("{:.7g}", fmt::join(values, " "));
}

/// gnuplot's: between single quotes, nothing but these is special.
std::string literal(const std::string& text) {
    std::string result = "'";
    for (const char c : text) result += c == '\'' ? "''" : c == '\n' ? " " : std::string(1, c);
    return result + "'";
}

bool can_show(double value, const Axis& axis) {
    if (axis.value == "psnr" && value >= 999) return false; // stands for infinite
    return std::isfinite(value) && (!axis.logarithmic || value > 0);
}

/// Okabe and Ito's colours, told apart by the colour-blind too, with a point's shape each.
struct Style {
    const char* color;
    int point;
};
constexpr Style kStyles[] = {{"#0072b2", 7}, {"#d55e00", 5}, {"#009e73", 9}, {"#cc79a7", 13},
    {"#e69f00", 11}, {"#56b4e9", 15}, {"#000000", 6}, {"#8c564b", 4}, {"#7f7f00", 8},
    {"#6a3d9a", 12}, {"#a0a0a0", 10}};

bool same(const PlotPoint& a, const PlotPoint& b) {
    return a.x.median == b.x.median && a.y.median == b.y.median && a.setting == b.setting;
}

} // namespace

Curve curve(const std::vector<Point>& points, const std::string& scene, const std::string& series,
    const Plot& plot, std::string legend, Curve::Kind kind) {
    Curve result{.legend = std::move(legend), .kind = kind, .points = {}};
    for (const Point& point : points) {
        if (point.job->scene != scene || point.job->series != series) continue;
        PlotPoint drawn;
        const std::optional<Spread> x = value_of(point, plot.x, drawn.x_values);
        const std::optional<Spread> y = value_of(point, plot.y, drawn.y_values);
        if (!x || !y) continue;
        drawn.x = *x;
        drawn.y = *y;
        drawn.setting = point.job->setting;
        drawn.command = point.job->command;
        result.points.push_back(std::move(drawn));
    }
    return result;
}

std::vector<PlotPoint> pareto_front(const Plot& plot) {
    std::vector<PlotPoint> all, front;
    if (plot.x.better == Better::neither || plot.y.better == Better::neither) return front;
    for (const Curve& c : plot.curves)
        if (c.competes && c.kind != Curve::Kind::limit)
            all.insert(all.end(), c.points.begin(), c.points.end());
    for (const PlotPoint& point : all) {
        if (std::none_of(all.begin(), all.end(),
                [&](const PlotPoint& other) { return dominates(plot, other, point); })) {
            front.push_back(point);
        }
    }
    std::stable_sort(front.begin(), front.end(),
        [](const PlotPoint& a, const PlotPoint& b) { return a.x.median < b.x.median; });
    return front;
}

std::string csv_cell(const std::string& text) {
    if (text.find_first_of(",\"\n") == std::string::npos) return text;
    std::string result = "\"";
    for (const char c : text) result += c == '"' ? std::string("\"\"") : std::string(1, c);
    return result + "\"";
}

std::string csv(const Plot& plot) {
    const std::vector<PlotPoint> front = pareto_front(plot);
    std::string text = fmt::format("series,setting,{0},{0}_low,{0}_high,{1},{1}_low,{1}_high,"
                                   "{0}_values,{1}_values,front,command\n",
        plot.x.value, plot.y.value);
    for (const Curve& c : plot.curves) {
        for (const PlotPoint& p : c.points) {
            const bool on_front = c.competes && c.kind != Curve::Kind::limit &&
                                  std::any_of(front.begin(), front.end(),
                                      [&](const PlotPoint& other) { return same(p, other); });
            text += fmt::format("{},{},{:.7g},{:.7g},{:.7g},{:.7g},{:.7g},{:.7g},{},{},{},{}\n",
                csv_cell(c.legend), csv_cell(p.setting), p.x.median, p.x.low, p.x.high, p.y.median,
                p.y.low, p.y.high, joined(p.x_values), joined(p.y_values), on_front ? 1 : 0,
                csv_cell(p.command));
        }
    }
    for (const Mark& mark : plot.marks) {
        const auto number = [](std::optional<double> value) {
            return value ? fmt::format("{:.7g}", *value) : "";
        };
        text += fmt::format(
            "{},mark,{},,,{},,,,,,\n", csv_cell(mark.label), number(mark.x), number(mark.y));
    }
    return text;
}

std::string gnuplot_script(const Plot& plot, const std::filesystem::path& svg) {
    // Every curve is a block of data: x, y, and their reach.
    std::string data, drawn;
    const auto add = [&](const std::vector<PlotPoint>& points, const std::string& how,
                         const std::string& title) {
        const std::size_t block =
            static_cast<std::size_t>(std::count(data.begin(), data.end(), '$'));
        std::string rows;
        for (const PlotPoint& p : points) {
            if (!can_show(p.x.median, plot.x) || !can_show(p.y.median, plot.y)) continue;
            rows += fmt::format("{:.9g} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g}\n", p.x.median,
                p.y.median, p.x.low, p.x.high, p.y.low, p.y.high);
        }
        if (rows.empty()) return;
        data += fmt::format("$d{} << EOD\n{}EOD\n", block, rows);
        drawn += fmt::format("{}$d{} {} title {}", drawn.empty() ? "plot " : ", \\\n     ", block,
            how, title.empty() ? "''" : literal(title));
    };
    if (const std::vector<PlotPoint> front = pareto_front(plot); front.size() > 1) {
        const char* steps = plot.x.better == Better::less ? "steps" : "fsteps";
        add(front, fmt::format("using 1:2 with {} lc '#d8d8d8' lw 7", steps), "Pareto front");
    }
    std::size_t style = 0, limits = 0;
    for (const Curve& c : plot.curves) {
        if (c.kind == Curve::Kind::limit) {
            add(c.points,
                fmt::format("using 1:2 with lines lc '#707070' lw 1.4 dt {}", 2 + limits++ % 4),
                c.legend);
            continue;
        }
        const Style s = kStyles[style++ % std::size(kStyles)];
        if (c.kind == Curve::Kind::line)
            add(c.points, fmt::format("using 1:2 with lines lc '{}' lw 1.8", s.color), "");
        // Bars under the points, which carry the legend.
        add(c.points,
            fmt::format("using 1:2:3:4:5:6 with xyerrorbars lc '{}' lw 0.9 pt -1", s.color), "");
        add(c.points,
            fmt::format("using 1:2 with {} lc '{}' lw 1.8 pt {} ps 0.75",
                c.kind == Curve::Kind::line ? "linespoints" : "points", s.color, s.point),
            c.legend);
    }
    std::string marks;
    for (const Mark& mark : plot.marks) {
        if (mark.x && mark.y) {
            marks +=
                fmt::format("set label {0} at first {1:.9g}, first {2:.9g} point pt 3 ps 1.6 lw 2 "
                            "lc '#000000' offset 0.9,0.6 front tc '#000000'\n",
                    literal(mark.label), *mark.x, *mark.y);
        } else if (mark.x) {
            marks += fmt::format("set arrow from first {0:.9g}, graph 0 to first {0:.9g}, graph 1 "
                                 "nohead lc '#404040' lw 1 dt 3\nset label {1} at first {0:.9g}, "
                                 "graph 0.03 rotate by 90 left offset -0.6,0 tc '#404040'\n",
                *mark.x, literal(mark.label));
        } else if (mark.y) {
            marks +=
                fmt::format("set arrow from graph 0, first {0:.9g} to graph 1, first {0:.9g} "
                            "nohead lc '#404040' lw 1 dt 3\nset label {1} at graph 0.99, first "
                            "{0:.9g} right offset 0,0.5 tc '#404040'\n",
                    *mark.y, literal(mark.label));
        }
    }
    return fmt::format(R"(set encoding utf8
set terminal svg size 760,520 noenhanced background '#ffffff' font 'Helvetica,14' linewidth 1.1
set output {}
set title {} font ',16'
set xlabel {}
set ylabel {}
{}{}set grid back lc '#e6e6e6' lw 0.8
set border 3 lc '#404040'
set tics nomirror out scale 0.6
set offsets graph 0.02, graph 0.02, graph 0.04, graph 0.04
set bars 0.4
set key below left Left reverse samplen 2.2 spacing 1.15 width 1 maxrows 4
{}{}{}
)",
        literal(svg.string()), literal(plot.question), literal(plot.x.label), literal(plot.y.label),
        plot.x.logarithmic ? "set logscale x\n" : "", plot.y.logarithmic ? "set logscale y\n" : "",
        data, marks, drawn);
}

bool gnuplot_is_installed() { return std::system("command -v gnuplot >/dev/null 2>&1") == 0; }

void draw(const Plot& plot, const std::filesystem::path& svg) {
    write_atomically(svg, [&](const std::filesystem::path& temporary) {
        const std::string script = gnuplot_script(plot, temporary);
        FILE* pipe = ::popen("gnuplot", "w");
        if (pipe == nullptr) fail_input("cannot start gnuplot for '{}'", svg.string());
        std::fwrite(script.data(), 1, script.size(), pipe);
        if (::pclose(pipe) != 0)
            fail_input("gnuplot could not draw '{}'; its message is above", svg.string());
    });
}

} // namespace ockham::chart

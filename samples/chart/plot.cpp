// SPDX-License-Identifier: Apache-2.0
#include "samples/chart/plot.hpp"

#include "framework/core/error.hpp"
#include "framework/core/file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
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
    if (axis.most && value > *axis.most) return false;
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

/// The parts of what gnuplot is told.
class Script {
public:
    explicit Script(const Plot& plot) : plot_(plot) {
        if (const std::vector<PlotPoint> front = pareto_front(plot); front.size() > 1)
            add(front, "using 1:2 with steps lc '#d4d4d4' lw 7", "Pareto front");
        std::size_t style = 0, limits = 0;
        for (const Curve& c : plot.curves) {
            if (c.kind == Curve::Kind::limit) {
                add(c.points,
                    fmt::format("using 1:2 with lines lc '#505050' lw 1.5 dt {}", 2 + limits++ % 4),
                    c.legend);
            } else {
                add(c, kStyles[style++ % std::size(kStyles)]);
            }
        }
        for (const Mark& mark : plot.marks) add(mark);
    }

    const std::string& data() const { return data_; }
    const std::string& marks() const { return marks_; }
    const std::string& curves() const { return curves_; }
    /// Four columns, or three where a text is long.
    std::size_t legend_rows() const {
        const std::size_t columns = longest_ > 26 ? 2 : longest_ > 17 ? 3 : 4;
        return (legends_ + columns - 1) / columns;
    }
    /// Range and, where logarithmic, ticks: 1, 2, 5 of each decade unless there are many.
    std::string axis(const char* name, const Axis& axis) const {
        const bool is_x = name[0] == 'x';
        double low = is_x ? x_low_ : y_low_, high = is_x ? x_high_ : y_high_;
        if (!(low <= high)) return {};
        if (!axis.logarithmic) {
            const double margin =
                high > low ? 0.05 * (high - low) : 0.05 * std::max(std::abs(low), 1e-9);
            high = axis.most && high + margin > *axis.most ? *axis.most : high + margin;
            return fmt::format("set {}range [{:.9g}:{:.9g}]\n", name, low - margin, high);
        }
        const double margin = std::max(std::pow(high / low, 0.05), 1.02);
        low /= margin, high *= margin;
        const bool few = high / low < 500;
        std::string ticks;
        for (int decade = static_cast<int>(std::floor(std::log10(low))); decade < 30; ++decade) {
            for (const int digit : {1, 2, 5}) {
                const double tick = digit * std::pow(10.0, decade);
                if (tick < low || tick > high || (digit != 1 && !few)) continue;
                ticks += fmt::format("{}'{:g}' {:.9g}", ticks.empty() ? "" : ", ", tick, tick);
            }
        }
        return fmt::format("set logscale {0}\nset {0}range [{1:.9g}:{2:.9g}]\nset {0}tics ({3})\n",
            name, low, high, ticks);
    }

private:
    void reach(double x, double y) {
        x_low_ = std::min(x_low_, x), x_high_ = std::max(x_high_, x);
        y_low_ = std::min(y_low_, y), y_high_ = std::max(y_high_, y);
    }

    /// A text to the right of `x` would leave the picture.
    bool ends_at(double x) const {
        const bool logarithmic = plot_.x.logarithmic && x_low_ > 0;
        const auto place = [&](double v) { return logarithmic ? std::log(v) : v; };
        return place(x) > place(x_low_) + 0.85 * (place(x_high_) - place(x_low_));
    }

    /// A block of data, x, y and their reach, and a part of the plot command that draws it.
    void add(
        const std::vector<PlotPoint>& points, const std::string& how, const std::string& title) {
        std::string rows;
        for (const PlotPoint& p : points) {
            if (!can_show(p.x.median, plot_.x) || !can_show(p.y.median, plot_.y)) continue;
            rows += fmt::format("{:.9g} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g}\n", p.x.median,
                p.y.median, p.x.low, p.x.high, p.y.low, p.y.high);
            reach(p.x.median, p.y.median);
        }
        if (rows.empty()) return;
        data_ += fmt::format("$d{} << EOD\n{}EOD\n", blocks_, rows);
        curves_ += fmt::format("{}$d{} {} title {}", curves_.empty() ? "plot " : ", \\\n     ",
            blocks_, how, title.empty() ? "''" : literal(title));
        ++blocks_;
        if (title.empty()) return;
        ++legends_;
        longest_ = std::max(longest_, title.size());
    }

    void add(const Curve& c, const Style& style) {
        const bool is_line = c.kind == Curve::Kind::line;
        // Bars first, paler, so that the points stand out.
        add(c.points,
            fmt::format(
                "using 1:2:3:4:5:6 with xyerrorbars lc rgb '#90{}' lw 0.8 pt -1", style.color + 1),
            "");
        add(c.points,
            fmt::format("using 1:2 with {} lc '{}' lw 1.9 pt {} ps 0.8",
                is_line ? "linespoints" : "points", style.color, style.point),
            c.legend);
    }

    void add(const Mark& mark) {
        const std::string label = literal(mark.label);
        if (mark.x && mark.y) {
            reach(*mark.x, *mark.y);
            const char* side = ends_at(*mark.x) ? "right offset -0.8,-0.6" : "left offset 0.8,-0.6";
            marks_ += fmt::format("set label {} at first {:.9g}, first {:.9g} {} point pt 3 ps 1.5 "
                                  "lw 2 lc '#000000' front tc '#000000'\n",
                label, *mark.x, *mark.y, side);
        } else if (mark.x) {
            x_low_ = std::min(x_low_, *mark.x), x_high_ = std::max(x_high_, *mark.x);
            marks_ += fmt::format("set arrow from first {0:.9g}, graph 0 to first {0:.9g}, graph 1 "
                                  "nohead lc '#404040' lw 1 dt 3\nset label {1} at first {0:.9g}, "
                                  "graph 0.03 rotate by 90 left offset -0.6,0 tc '#404040' "
                                  "font ',13'\n",
                *mark.x, label);
        } else if (mark.y) {
            y_low_ = std::min(y_low_, *mark.y), y_high_ = std::max(y_high_, *mark.y);
            marks_ += fmt::format("set arrow from graph 0, first {0:.9g} to graph 1, first {0:.9g} "
                                  "nohead lc '#404040' lw 1 dt 3\nset label {1} at graph 0.01, "
                                  "first {0:.9g} left offset 0,0.5 tc '#404040' font ',13'\n",
                *mark.y, label);
        }
    }

    const Plot& plot_;
    std::string data_, marks_, curves_;
    std::size_t blocks_ = 0, legends_ = 0, longest_ = 0;
    double x_low_ = INFINITY, x_high_ = -INFINITY, y_low_ = INFINITY, y_high_ = -INFINITY;
};

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

std::string stem_of(const std::string& text) {
    std::string stem;
    for (const char c : text)
        stem += std::isalnum(static_cast<unsigned char>(c))
                    ? static_cast<char>(std::tolower(static_cast<unsigned char>(c)))
                    : '_';
    return stem;
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
    const Script script(plot);
    return fmt::format(R"(set encoding utf8
set terminal svg size 760,540 noenhanced background '#ffffff' font 'Helvetica,15' linewidth 1.1
set output {}
set title {} font ',17'
set xlabel {} offset 0,0.3
set ylabel {}
{}{}set grid back lc '#e8e8e8' lw 0.8
set border 3 lc '#404040'
set tics nomirror out scale 0.6
set bars 0.3
set bmargin {}
set key at screen 0.51, screen 0.015 center bottom vertical maxrows {} Left reverse samplen 1.8 font ',13'
{}{}{}
)",
        literal(svg.string()), literal(plot.question), literal(plot.x.label), literal(plot.y.label),
        script.axis("x", plot.x), script.axis("y", plot.y),
        3.9 + 0.95 * static_cast<double>(script.legend_rows()), script.legend_rows(), script.data(),
        script.marks(), script.curves());
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

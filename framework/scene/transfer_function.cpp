// SPDX-License-Identifier: Apache-2.0
#include "framework/scene/transfer_function.hpp"

#include "framework/core/error.hpp"
#include "framework/core/json_object.hpp"
#include "framework/scene/histogram.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

namespace ockham {

namespace {

constexpr std::size_t kTableEntries = 4096;
constexpr double kLargest = std::numeric_limits<float>::max();

TransferPoint mix(const TransferPoint& a, const TransferPoint& b, double value) {
    const double t = (value - a.value) / (b.value - a.value);
    return {value, a.opacity + (b.opacity - a.opacity) * t, glm::mix(a.color, b.color, t),
        glm::mix(a.emission, b.emission, t)};
}

glm::dvec3 read_color(
    const JsonObject& source, const char* key, double high, const char* expected, double fallback) {
    if (!source.has(key)) return glm::dvec3(fallback);
    const std::array<double, 3> c = source.numbers<3>(key, 0, high, expected);
    return {c[0], c[1], c[2]};
}

TransferPoint read_point(const JsonObject& source) {
    source.warn_unknown({"value", "opacity", "color", "emission"});
    TransferPoint point;
    point.value = source.number("value", -kLargest, kLargest, "a number");
    point.opacity = source.number("opacity", 0, 1, "a number from 0 to 1");
    point.color = read_color(source, "color", 1, "three numbers from 0 to 1", 1);
    point.emission = read_color(source, "emission", kLargest, "three numbers of at least 0", 0);
    return point;
}

/// Outside of [low, high] the function's values at these hold.
TransferFunction within(const TransferFunction& function, double low, double high) {
    TransferFunction result;
    for (const TransferPoint& point : function.points)
        if (point.value >= low && point.value <= high) result.points.push_back(point);
    std::vector<TransferPoint>& points = result.points;
    if (points.empty() || points.front().value > low)
        points.insert(points.begin(), function.at(low));
    if (points.back().value < high) points.push_back(function.at(high));
    return result;
}

/// The histogram's levels that functions are laid by.
struct Levels {
    double lowest, threshold, bright;
};

Levels levels_of(const Volume& volume) {
    const Histogram counts = histogram(volume);
    Levels levels{counts.low, otsu_threshold(counts), percentile(counts, 0.995)};
    if (levels.bright <= levels.threshold) levels.bright = counts.high; // little but emptiness
    return levels;
}

bool is_constant(const Levels& levels) { return levels.lowest == levels.bright; }

/// There is nothing to tell apart: matter if above 0.
TransferFunction constant_transfer(double value) { return {{{value, value > 0 ? 1.0 : 0.0}}}; }

TransferFunction ct_bone() {
    const glm::dvec3 marrow(0.88, 0.76, 0.60), ivory(0.93, 0.86, 0.74), enamel(0.98, 0.96, 0.92);
    return {{{150, 0.0, marrow}, {300, 0.25, marrow}, {700, 0.8, ivory}, {1500, 1.0, enamel},
        {3000, 1.0, glm::dvec3(1.0)}}};
}

TransferFunction ct_soft() {
    const glm::dvec3 skin(0.90, 0.68, 0.55), fat(0.94, 0.84, 0.58), muscle(0.74, 0.36, 0.30),
        vessel(0.80, 0.45, 0.36), ivory(0.93, 0.86, 0.74);
    return {{{-250, 0.0, skin}, {-150, 0.03, skin}, {-100, 0.03, fat}, {-20, 0.05, fat},
        {30, 0.22, muscle}, {80, 0.28, muscle}, {180, 0.34, vessel}, {300, 0.6, ivory},
        {1000, 1.0, ivory}}};
}

TransferFunction mri(const Levels& levels) {
    const glm::dvec3 skin(0.86, 0.66, 0.58), grey_matter(0.80, 0.70, 0.66),
        bright(0.96, 0.93, 0.90);
    const auto between = [](double a, double b) { return 0.5 * (a + b); };
    return {{{between(levels.lowest, levels.threshold), 0.0, skin}, {levels.threshold, 0.1, skin},
        {between(levels.threshold, levels.bright), 0.5, grey_matter},
        {levels.bright, 1.0, bright}}};
}

TransferFunction smoke(const Levels& levels) {
    const glm::dvec3 grey(0.8);
    return {{{levels.lowest, 0.0, grey}, {levels.bright, 1.0, grey}}};
}

} // namespace

TransferPoint TransferFunction::at(double value) const {
    const auto above = std::upper_bound(points.begin(), points.end(), value,
        [](double v, const TransferPoint& point) { return v < point.value; });
    if (above == points.begin()) return points.front();
    if (above == points.end()) return points.back();
    return mix(*(above - 1), *above, value);
}

bool TransferFunction::emits() const {
    return std::any_of(points.begin(), points.end(),
        [](const TransferPoint& point) { return point.emission != glm::dvec3(0.0); });
}

TransferFunction load_transfer(const std::filesystem::path& path) {
    return transfer_from_json(parse_json(path, "transfer function"), path.string());
}

TransferFunction transfer_from_json(const nlohmann::json& json, const std::string& file) {
    const JsonObject source(json, "transfer function", file);
    source.warn_unknown({"domain", "points"});
    TransferFunction function;
    for (const JsonObject& item : source.objects("points")) {
        const TransferPoint point = read_point(item);
        if (!function.points.empty() && point.value < function.points.back().value)
            item.refuse("value", "at least that of the point before");
        function.points.push_back(point);
    }
    if (function.points.empty()) source.refuse("points", "at least one point");
    if (!source.has("domain")) return function;
    const auto [low, high] = source.numbers<2>("domain", -kLargest, kLargest, "two numbers");
    if (!(low < high)) source.refuse("domain", "a lower and a higher number");
    return within(function, low, high);
}

TransferFunction default_transfer(const Volume& volume) {
    const Levels levels = levels_of(volume);
    if (is_constant(levels)) return constant_transfer(levels.lowest);
    return {{{levels.threshold, 0.0}, {levels.bright, 1.0}}};
}

TransferFunction preset_transfer(const std::string& name, const Volume& volume) {
    if (name == "ct-bone") return ct_bone();
    if (name == "ct-soft") return ct_soft();
    if (name != "mri" && name != "smoke")
        fail_input("no transfer function '{}': presets are ct-bone, ct-soft, mri, smoke", name);
    const Levels levels = levels_of(volume);
    if (is_constant(levels)) return constant_transfer(levels.lowest);
    return name == "mri" ? mri(levels) : smoke(levels);
}

TransferFunction window_transfer(double level, double width) {
    check(width >= 0, "a window has a width of at least 0");
    return {{{level - 0.5 * width, 0.0}, {level + 0.5 * width, 1.0}}};
}

float TransferTable::max_opacity(double low, double high) const {
    const double per_value = double(entries.size() - 1) / (last - first);
    const auto place_of = [&](double value) {
        return std::clamp((value - first) * per_value, 0.0, double(entries.size() - 1));
    };
    const auto opacity_at = [this](double place) {
        const std::size_t entry = std::min(static_cast<std::size_t>(place), entries.size() - 2);
        return glm::mix(
            double(entries[entry].w), double(entries[entry + 1].w), place - double(entry));
    };
    const double from = place_of(std::min(low, high)), to = place_of(std::max(low, high));
    double result = std::max(opacity_at(from), opacity_at(to));
    for (double entry = std::ceil(from); entry <= to; ++entry)
        result = std::max(result, double(entries[static_cast<std::size_t>(entry)].w));
    return static_cast<float>(result);
}

TransferTable tabulate(const TransferFunction& function, const Volume& volume) {
    const auto [lowest, highest] = value_range(volume);
    const double codes = std::round((highest - lowest) / volume.value_scale) + 1;
    const bool per_code = volume.type != VoxelType::float32 && codes <= double(kTableEntries);
    std::size_t count = per_code ? static_cast<std::size_t>(codes) : kTableEntries;
    TransferTable table{lowest, highest, {}, {}};
    const double front = function.points.front().value, back = function.points.back().value;
    if (!per_code && front < back && front < highest && back > lowest) {
        // Beyond its ends the function is constant, however far a stray voxel lies. An entry more
        // on each side, for an end may be a step.
        const double beyond = (back - front) / double(count - 3);
        table.first = std::max(lowest, front - beyond);
        table.last = std::min(highest, back + beyond);
    }
    if (table.first == table.last) { // two equal entries: tables are never of no width
        count = 2;
        table.last = table.first + std::max(1.0, std::abs(table.first));
    }
    // As Volume::at() computes them, so that a code's entry is the function at exactly its value.
    const double first_code = std::round((lowest - volume.value_offset) / volume.value_scale);
    for (std::size_t i = 0; i < count; ++i) {
        const double value =
            per_code ? volume.value_offset + volume.value_scale * (first_code + double(i))
                     : table.first + (table.last - table.first) * double(i) / double(count - 1);
        const TransferPoint point = function.at(std::min(value, highest));
        table.entries.push_back(glm::vec4(point.color, point.opacity));
        if (function.emits()) table.emission.push_back(glm::vec3(point.emission));
    }
    return table;
}

} // namespace ockham

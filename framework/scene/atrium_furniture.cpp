// SPDX-License-Identifier: Apache-2.0
#include "framework/core/rng.hpp"
#include "framework/scene/atrium_parts.hpp"

#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace ockham::atrium {

namespace {

/// Link of a chain: a ring stretched along `along`, flat in the plane of `along` and `across`.
void add_link(Shape& shape, glm::dvec3 center, glm::dvec3 along, glm::dvec3 across) {
    constexpr double kBend = 0.022;
    constexpr double kStraight = 0.028;
    std::vector<Frame> path;
    double u = 0.0;
    for (int i = 0; i <= 12; ++i) {
        const int step = i % 12;
        const bool far_end = step < 6;
        const glm::dvec2 a = unit_at(((far_end ? step : step - 1) - 2.5) / 10.0);
        const glm::dvec3 right = along * a.x + across * a.y;
        const glm::dvec3 forward = across * a.x - along * a.y;
        path.push_back({center + along * (far_end ? kStraight : -kStraight) + right * kBend, right,
            glm::cross(forward, right), u, 0.0});
        u += 0.02;
    }
    // The frames stand on the wire's axis: `right` and `up` span the wire's round section.
    add_sweep(shape, path, circle_profile(0.0085, 5));
}

/// Hanging chain of `count` links that ends at y = 0.
void add_hanging_chain(Shape& shape, int count) {
    for (int i = 0; i < count; ++i)
        add_link(shape, {0, (i + 0.5) * kLinkPitch, 0}, {0, 1, 0},
            i % 2 == 0 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 0, 1));
}

} // namespace

void add_slack_chain(Shape& shape, double half, double sag) {
    const auto point = [&](double z) {
        return glm::dvec3(0, sag * ((z / half) * (z / half) - 1.0), z);
    };
    bool upright = true;
    for (double z = 0.0; z < half; upright = !upright) {
        // Step by one pitch along the parabola; the slope changes little within a link.
        const double slope = 2.0 * sag * z / (half * half);
        const double run = kLinkPitch / std::sqrt(1.0 + slope * slope);
        for (const double side : {1.0, -1.0}) {
            if (side < 0.0 && z == 0.0) continue;
            const glm::dvec3 along = glm::normalize(glm::dvec3(0, side * slope, 1));
            const glm::dvec3 normal = glm::cross(along, glm::dvec3(1, 0, 0));
            add_link(shape, point(side * z), along, upright ? normal : glm::dvec3(1, 0, 0));
        }
        z += run;
    }
}

namespace {

/// Six-sided frustum with both ends.
void add_hexagon(Shape& shape, double low_y, double low_radius, double high_y, double high_radius) {
    std::vector<glm::dvec3> low, high;
    for (int i = 0; i < 6; ++i) {
        const glm::dvec2 a = unit_at(-i / 6.0); // counter-clockwise seen from above
        low.emplace_back(a.x * low_radius, low_y, a.y * low_radius);
        high.emplace_back(a.x * high_radius, high_y, a.y * high_radius);
    }
    for (int i = 0; i < 6; ++i)
        add_quad(shape, low[i], low[(i + 1) % 6], high[(i + 1) % 6], high[i]);
    add_polygon(shape, high);
    add_polygon(shape, std::vector(low.rbegin(), low.rend()));
}

} // namespace

Mesh lantern_mesh(const Materials& m, std::string name, int links) {
    Shape iron(m.iron);
    add_hanging_chain(iron, links);
    add_rod(iron, {0, -0.12, 0}, {0, 0.015, 0}, 0.014, 8);
    add_hexagon(iron, -0.22, 0.19, -0.08, 0.04);
    add_hexagon(iron, -0.245, 0.17, -0.215, 0.17);
    add_hexagon(iron, -0.60, 0.12, -0.56, 0.12);
    add_hexagon(iron, -0.68, 0.02, -0.59, 0.08);
    for (int i = 0; i < 6; ++i) {
        const glm::dvec2 a = unit_at(i / 6.0);
        add_rod(iron, {a.x * 0.11, -0.57, a.y * 0.11}, {a.x * 0.155, -0.23, a.y * 0.155}, 0.010, 5);
    }
    Shape glass(m.glass);
    add_hexagon(glass, -0.565, 0.095, -0.24, 0.135);
    return {std::move(name), {iron.take(), glass.take()}};
}

Mesh banner_mesh(const Materials& m, std::string name, int cloth_material) {
    constexpr int kColumns = 28;
    constexpr int kRows = 36;
    constexpr double kWidth = 1.5;
    Shape cloth(cloth_material);
    const auto point = [](double s, double t) {
        const double fold = unit_at(3.5 * s + 0.18 * t).y + 0.35 * unit_at(8.0 * s - 0.3 * t).y;
        const double point_down = 1.0 - std::abs(2.0 * s - 1.0);
        const double width = kWidth * (1.0 - 0.05 * t);
        return glm::dvec3((s - 0.5) * width, -(2.55 + 0.40 * point_down) * t,
            0.265 + (0.012 + 0.045 * t) * fold + 0.05 * t * t);
    };
    add_grid(cloth, kColumns, kRows, [&](int i, int j) {
        constexpr double kStep = 1.0 / 1024;
        const double s = double(i) / kColumns;
        const double t = double(j) / kRows;
        const glm::dvec3 right = point(s + kStep, t) - point(s - kStep, t);
        const glm::dvec3 down = point(s, t + kStep) - point(s, t - kStep);
        return ShapeVertex{point(s, t), glm::cross(down, right), right, {s, t}};
    });
    Shape iron(m.iron);
    add_rod(iron, {-0.85, 0.0, 0.25}, {0.85, 0.0, 0.25}, 0.018, 10);
    for (const double x : {-0.81, 0.81}) add_rod(iron, {x, 0.0, -0.2}, {x, 0.0, 0.26}, 0.014, 8);
    return {std::move(name), {cloth.take(), iron.take()}};
}

namespace {

/// Leaves in a ball: twigs that point outward and a little up.
void add_crown(Shape& shape, glm::dvec3 center, double radius, int count, Pcg32& rng) {
    for (int i = 0; i < count; ++i) {
        const glm::dvec3 out = random_direction(rng);
        const double reach = radius * (0.35 + 0.45 * rng.uniform());
        const glm::dvec3 along = out + glm::dvec3(0, 0.35, 0) + 0.5 * random_direction(rng);
        const glm::dvec3 face = glm::dvec3(0, 1, 0) + 0.9 * random_direction(rng) + 0.4 * out;
        add_sprig(shape, center + out * reach * glm::dvec3(1, 0.85, 1), along, face,
            0.26 + 0.12 * rng.uniform());
    }
}

} // namespace

Mesh planter_mesh(const Materials& m, std::string name, double trunk, double radius, int leaves,
    std::uint64_t seed) {
    Pcg32 rng(seed);
    Shape clay(m.clay);
    Profile pot;
    pot.points = {{0.22, -0.02}, {0.24, 0.02}, {0.24, 0.05}, {0.22, 0.07}, {0.28, 0.22},
        {0.33, 0.38}, {0.35, 0.50}, {0.36, 0.52}, {0.40, 0.53}, {0.41, 0.56}, {0.41, 0.60},
        {0.40, 0.62}, {0.35, 0.62}, {0.33, 0.60}, {0.32, 0.50}};
    add_lathe(clay, glm::dvec3(0), pot, 28);
    Shape earth(m.earth);
    Profile soil;
    soil.points = {{0.335, 0.55}, {0.2, 0.57}, {0.0, 0.58}};
    add_lathe(earth, glm::dvec3(0), soil, 16);
    Shape bark(m.bark);
    const double top = 0.58 + trunk;
    if (trunk > 0.0) add_rod(bark, {0, 0.5, 0}, {0.02, top, 0.01}, 0.035, 9);
    for (int i = 0; i < 7; ++i) {
        const glm::dvec2 a = unit_at((i + 0.4 * rng.uniform()) / 7.0);
        add_rod(bark, {0.01, top - 0.12, 0.01},
            {0.55 * radius * a.x, top + 0.6 * radius * (0.5 + rng.uniform()), 0.55 * radius * a.y},
            0.012, 5);
    }
    Shape leaf(m.leaf);
    add_crown(leaf, {0, top + 0.62 * radius, 0}, radius, leaves, rng);
    return {std::move(name), {clay.take(), earth.take(), bark.take(), leaf.take()}};
}

Mesh creeper_mesh(const Materials& m) {
    Pcg32 rng(7);
    Shape leaf(m.leaf);
    for (int strand = 0; strand < 15; ++strand) {
        const double x = -1.05 + 2.1 * strand / 14.0 + 0.08 * (double{rng.uniform()} - 0.5);
        const double length = 0.45 + 1.25 * rng.uniform();
        const int count = 4 + static_cast<int>(length * 9.0);
        for (int i = 0; i < count; ++i) {
            const double t = (i + double{rng.uniform()}) / count;
            // Braces: the random numbers are drawn from left to right.
            const glm::dvec3 base{x + 0.12 * (double{rng.uniform()} - 0.5), 0.08 - length * t,
                0.05 + 0.08 * rng.uniform()};
            const glm::dvec3 along =
                glm::dvec3(0, -0.7, 0.5) + 0.9 * random_direction(rng) * glm::dvec3(1, 0.6, 0.3);
            const glm::dvec3 face = glm::dvec3(0, 0.5, 1) + 0.4 * random_direction(rng);
            add_sprig(leaf, base, along, face, 0.18 + 0.08 * rng.uniform());
        }
    }
    return {"creeper", {leaf.take()}};
}

Mesh fountain_mesh(const Materials& m) {
    constexpr int kSides = 48;
    Shape stone(m.limestone);
    Profile basin;
    basin.points = {{1.62, -0.03}, {1.62, 0.10}, {1.52, 0.11}, {1.48, 0.14}, {1.45, 0.18},
        {1.42, 0.26}, {1.42, 0.36}, {1.45, 0.42}, {1.50, 0.46}, {1.56, 0.48}, {1.58, 0.52},
        {1.56, 0.57}, {1.52, 0.58}, {1.38, 0.58}, {1.34, 0.56}, {1.32, 0.52}, {1.30, 0.25}};
    add_lathe(stone, glm::dvec3(0), basin, kSides);
    Profile stem;
    stem.points = {{0.34, 0.20}, {0.34, 0.52}, {0.31, 0.55}, {0.24, 0.58}, {0.19, 0.66},
        {0.17, 0.74}, {0.21, 0.78}, {0.23, 0.82}, {0.21, 0.86}, {0.15, 0.90}, {0.13, 1.00},
        {0.13, 1.10}, {0.16, 1.16}, {0.28, 1.20}, {0.48, 1.26}, {0.64, 1.34}, {0.74, 1.44},
        {0.79, 1.47}, {0.80, 1.51}, {0.78, 1.54}, {0.73, 1.54}, {0.66, 1.46}, {0.50, 1.38}};
    add_lathe(stone, glm::dvec3(0), stem, kSides);
    Profile finial;
    finial.points = {{0.17, 1.36}, {0.16, 1.54}, {0.11, 1.58}, {0.085, 1.66}, {0.11, 1.72},
        {0.17, 1.78}, {0.20, 1.86}, {0.18, 1.95}, {0.12, 2.02}, {0.06, 2.06}, {0.055, 2.10},
        {0.075, 2.14}, {0.075, 2.18}, {0.045, 2.23}, {0.0, 2.27}};
    add_lathe(stone, glm::dvec3(0), finial, 28);
    Shape water(m.water);
    Profile lower, upper;
    lower.points = {{1.33, 0.47}, {0.25, 0.47}};
    upper.points = {{0.70, 1.485}, {0.10, 1.485}};
    add_lathe(water, glm::dvec3(0), lower, kSides);
    add_lathe(water, glm::dvec3(0), upper, kSides);
    return {"fountain", {stone.take(), water.take()}};
}

} // namespace ockham::atrium

// SPDX-License-Identifier: Apache-2.0
#include "framework/scene/atrium_parts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace ockham::atrium {

namespace {

/// Frames of an arch in the xy plane about the origin, from -x to +x over the top; a profile's x
/// is the radius, its y is z.
std::vector<Frame> arch_path(double radius, int steps) {
    std::vector<Frame> path;
    for (int i = 0; i <= steps; ++i) {
        const double turns = 0.5 - 0.5 * i / steps;
        const glm::dvec2 a = unit_at(turns);
        path.push_back(
            {glm::dvec3(0), {a.x, a.y, 0}, {0, 0, 1}, radius * std::numbers::pi * i / steps, 0.0});
    }
    return path;
}

/// `profile` (x: out of the wall, y: up) along a wall that looks to +z and runs from -half to
/// half; `mitre` 1 for inner corners with equal walls at both ends.
void add_moulding(Shape& shape, double half, const Profile& profile, double mitre) {
    add_sweep(shape,
        std::array{Frame{{half, 0, 0}, {0, 0, 1}, {0, 1, 0}, 0.0, mitre},
            Frame{{-half, 0, 0}, {0, 0, 1}, {0, 1, 0}, 2.0 * half, -mitre}},
        profile);
}

} // namespace

Mesh arch_mesh(const Materials& m) {
    constexpr int kSteps = 20;
    constexpr double kHidden = kArchRadius + 0.1; // the wall ends inside the moulding
    Shape wall(m.ashlar, 1.5);
    for (const double side : {1.0, -1.0}) {
        const double z = side * kWall;
        // Mirrored in x and z for the back, which keeps the winding.
        const auto quad = [&](double x0, double y0, double x1, double y1) {
            add_quad(wall, {side * x0, y0, z}, {side * x1, y1, z}, {side * x1, kArchRise, z},
                {side * x0, kArchRise, z});
        };
        quad(kHidden, 0.0, 0.5 * kBay, 0.0);
        quad(-0.5 * kBay, 0.0, -kHidden, 0.0);
        for (int i = 0; i < kSteps; ++i) {
            const glm::dvec2 a = kHidden * unit_at(0.5 - 0.5 * i / kSteps);
            const glm::dvec2 b = kHidden * unit_at(0.5 - 0.5 * (i + 1) / kSteps);
            quad(a.x, a.y, b.x, b.y);
        }
    }
    Shape moulding(m.limestone);
    Profile section;
    const std::array<glm::dvec2, 8> half{{{0.20, 0.24}, {0.20, 0.30}, {0.17, 0.33}, {0.10, 0.33},
        {0.09, 0.30}, {0.03, 0.30}, {0.01, 0.29}, {0.0, 0.26}}};
    for (const glm::dvec2& p : half) section.points.emplace_back(kArchRadius + p.x, p.y);
    for (auto p = half.rbegin(); p != half.rend(); ++p)
        section.points.emplace_back(kArchRadius + p->x, -p->y);
    add_sweep(moulding, arch_path(kArchRadius, kSteps), section);
    add_prism(moulding,
        std::array<glm::dvec2, 4>{{{-0.08, 1.21}, {0.08, 1.21}, {0.12, 1.56}, {-0.12, 1.56}}}, 0.2,
        0.385);
    return {"arch", {wall.take(), moulding.take()}};
}

Mesh column_mesh(const Materials& m, std::string name, double height, double radius) {
    Shape stone(m.limestone);
    const double r = radius;
    const double h = height;
    add_box(stone, {-r - 0.09, -0.03, -r - 0.09}, {r + 0.09, 0.11, r + 0.09});
    Profile turned;
    turned.points = {{r + 0.045, 0.10}, {r + 0.075, 0.12}, {r + 0.085, 0.15}, {r + 0.075, 0.18},
        {r + 0.045, 0.20}, {r + 0.04, 0.215}, {r + 0.02, 0.23}, {r + 0.012, 0.26},
        {r + 0.025, 0.285}, {r + 0.035, 0.29}, {r + 0.05, 0.31}, {r + 0.05, 0.335},
        {r + 0.035, 0.355}, {r + 0.015, 0.36}, {r + 0.005, 0.38}, {r, 0.42}, {r, 0.36 * h},
        {0.965 * r, 0.58 * h}, {0.87 * r, h - 0.50}, {0.87 * r + 0.02, h - 0.49},
        {0.87 * r + 0.03, h - 0.47}, {0.87 * r + 0.02, h - 0.45}, {0.87 * r, h - 0.44},
        {0.88 * r, h - 0.37}, {0.93 * r, h - 0.31}, {1.05 * r, h - 0.25}, {1.22 * r, h - 0.205},
        {1.30 * r, h - 0.19}, {1.33 * r, h - 0.165}, {1.28 * r, h - 0.14}};
    add_lathe(stone, glm::dvec3(0), turned, 20);
    const double a = kWall + 0.10;
    add_prism(stone,
        std::array<glm::dvec2, 4>{
            {{-a + 0.03, h - 0.15}, {a - 0.03, h - 0.15}, {a, h - 0.11}, {-a, h - 0.11}}},
        -a + 0.015, a - 0.015);
    add_box(stone, {-a - 0.01, h - 0.115, -a - 0.01}, {a + 0.01, h + 0.01, a + 0.01});
    return {std::move(name), {stone.take()}};
}

Mesh pilaster_mesh(const Materials& m, std::string name, double height) {
    Shape stone(m.limestone);
    add_box(stone, {-0.28, -0.03, -0.05}, {0.28, 0.24, 0.24});
    add_box(stone, {-0.22, 0.20, -0.06}, {0.22, height - 0.1, 0.17});
    add_box(stone, {-0.25, height - 0.2, -0.07}, {0.25, height - 0.13, 0.205});
    add_box(stone, {-0.29, height - 0.14, -0.05}, {0.29, height + 0.01, 0.25});
    return {std::move(name), {stone.take()}};
}

Mesh vault_mesh(const Materials& m) {
    constexpr int kSteps = 16;
    Shape web(m.plaster, 3.0);
    for (int quarter = 0; quarter < 4; ++quarter) {
        const glm::dvec2 turn = unit_at(0.25 * quarter);
        const auto turned = [&](glm::dvec3 p) {
            return glm::dvec3(turn.x * p.x + turn.y * p.z, p.y, turn.x * p.z - turn.y * p.x);
        };
        add_grid(web, kSteps, 1, [&](int i, int j) {
            const glm::dvec2 a = unit_at(0.5 - 0.5 * i / kSteps); // barrel along local z
            const double x = kVaultRadius * a.x;
            const double z = j == 0 ? kVaultRadius : std::abs(x);
            return ShapeVertex{turned({x, kVaultRadius * a.y, z}), turned({-a.x, -a.y, 0}),
                turned({a.y, -a.x, 0}), {kVaultRadius * std::numbers::pi * i / kSteps, -z}};
        });
    }
    Shape stone(m.limestone);
    Profile rib;
    rib.points = {{0.06, 0.06}, {-0.05, 0.06}, {-0.09, 0.025}, {-0.09, -0.025}, {-0.05, -0.06},
        {0.06, -0.06}};
    const double root = std::sqrt(2.0);
    // The ribs' ends are buried in the arches and walls at the bay's corners.
    for (const double side : {1.0, -1.0}) {
        const glm::dvec3 diagonal = glm::dvec3(1, 0, side) / root;
        std::vector<Frame> path;
        for (int i = 0; i <= kSteps; ++i) {
            const glm::dvec2 a = unit_at(0.48 - 0.46 * i / kSteps);
            const glm::dvec3 outward =
                glm::normalize(diagonal * a.x + glm::dvec3(0, root * a.y, 0));
            path.push_back({kVaultRadius * (diagonal * (root * a.x) + glm::dvec3(0, a.y, 0)),
                outward, glm::cross(diagonal, glm::dvec3(0, 1, 0)), 3.4 * i / kSteps, 0.0});
        }
        add_sweep(stone, path, rib);
    }
    Profile boss;
    boss.points = {
        {0.0, -0.17}, {0.06, -0.165}, {0.10, -0.13}, {0.15, -0.12}, {0.17, -0.09}, {0.16, 0.02}};
    add_lathe(stone, {0, kVaultRadius, 0}, boss, 16);
    return {"vault", {web.take(), stone.take()}};
}

Mesh transverse_mesh(const Materials& m) {
    Shape stone(m.limestone);
    Profile section;
    section.points = {
        {1.52, 0.17}, {1.37, 0.17}, {1.33, 0.13}, {1.33, -0.13}, {1.37, -0.17}, {1.52, -0.17}};
    std::vector<Frame> path = arch_path(1.33, 20);
    for (Frame& frame : path) { // from the xy plane to the yz plane
        frame.right = {0, frame.right.y, -frame.right.x};
        frame.up = {1, 0, 0};
        frame.position = {0, 0, 1.4};
    }
    add_sweep(stone, path, section);
    return {"transverse_arch", {stone.take()}};
}

Mesh outer_wall_mesh(const Materials& m, std::string name, int material, double tile, bool door) {
    Shape face(material, tile);
    const double half = 0.5 * kBay;
    add_quad(face, {-half, -0.05, 0}, {half, -0.05, 0}, {half, 4.6, 0}, {-half, 4.6, 0});
    Shape dado(m.ashlar, 1.5);
    add_moulding(dado, half, {{{0.05, -0.03}, {0.05, 0.96}}}, 0.0);
    Shape stone(m.limestone);
    add_moulding(stone, half,
        {{{0.04, 0.95}, {0.07, 0.97}, {0.10, 1.01}, {0.10, 1.06}, {-0.02, 1.08}}}, 0.0);
    Mesh mesh{std::move(name), {}};
    if (door) {
        for (const double side : {-1.0, 1.0}) {
            const double x = side * 0.66;
            add_box(stone, {x - 0.1, -0.04, -0.06}, {x + 0.1, 2.22, 0.20});
        }
        add_box(stone, {-0.86, 2.2, -0.05}, {0.86, 2.42, 0.22});
        add_box(stone, {-0.94, 2.41, -0.07}, {0.94, 2.49, 0.28});
        Shape wood(m.wood);
        add_box(wood, {-0.58, -0.03, -0.03}, {0.58, 2.21, 0.13});
        mesh.primitives.push_back(wood.take());
        Shape iron(m.iron);
        for (const double y : {0.25, 1.75}) // straps
            add_box(iron, {-0.57, y, 0.06}, {0.45, y + 0.07, 0.14});
        add_rod(iron, {0.42, 1.16, 0.12}, {0.42, 1.16, 0.22}, 0.02, 8);
        add_rod(iron, {0.42, 1.05, 0.21}, {0.42, 1.27, 0.21}, 0.015, 8);
        mesh.primitives.push_back(iron.take());
    }
    mesh.primitives.push_back(face.take());
    mesh.primitives.push_back(dado.take());
    mesh.primitives.push_back(stone.take());
    return mesh;
}

Mesh balustrade_mesh(const Materials& m) {
    constexpr int kBalusters = 9;
    Shape stone(m.limestone);
    Profile turned;
    turned.points = {{0.065, 0.13}, {0.065, 0.18}, {0.04, 0.20}, {0.055, 0.27}, {0.085, 0.36},
        {0.08, 0.44}, {0.05, 0.56}, {0.036, 0.68}, {0.052, 0.71}, {0.04, 0.74}, {0.065, 0.78},
        {0.065, 0.85}};
    for (int i = 0; i < kBalusters; ++i) add_lathe(stone, {(i - 4) * 0.26, 0, 0}, turned, 8);
    add_box(stone, {-1.34, -0.04, -0.12}, {1.34, 0.14, 0.12});
    add_box(stone, {-1.33, 0.84, -0.11}, {1.33, 0.90, 0.11});
    add_box(stone, {-1.34, 0.89, -0.15}, {1.34, 1.0, 0.15});
    return {"balustrade", {stone.take()}};
}

Mesh dentil_mesh(const Materials& m) {
    Shape stone(m.limestone);
    for (int i = 0; i < 10; ++i) { // 0.3 m apart: none stands half in a corner of the court
        const double x = (i - 4.5) * 0.3;
        add_box(stone, {x - 0.065, 9.13, 0.22}, {x + 0.065, 9.225, kWall + 0.13});
    }
    return {"dentils", {stone.take()}};
}

Mesh bands_mesh(const Materials& m, std::string name, double half) {
    Shape stone(m.limestone);
    Profile step, string_course, cornice, soffit;
    step.points = {
        {0.30, -0.03}, {0.30, 0.115}, {0.325, 0.12}, {0.325, 0.145}, {0.32, 0.15}, {-0.55, 0.15}};
    string_course.points = {{-0.02, 4.73}, {0.03, 4.75}, {0.03, 4.79}, {0.05, 4.81}, {0.08, 4.83},
        {0.12, 4.87}, {0.16, 4.88}, {0.16, 4.95}, {0.18, 4.96}, {0.19, 4.99}, {0.19, 5.03},
        {0.17, 5.05}, {-0.55, 5.05}};
    cornice.points = {{-0.02, 8.98}, {0.04, 9.0}, {0.04, 9.10}, {0.06, 9.12}, {0.06, 9.22},
        {0.09, 9.24}, {0.15, 9.27}, {0.30, 9.29}, {0.30, 9.36}, {0.33, 9.38}, {0.36, 9.42},
        {0.38, 9.47}, {0.38, 9.50}, {0.0, 9.50}};
    soffit.points = {{0.2, 9.47}, {0.45, 9.47}, {0.45, 9.55}};
    for (const Profile* profile : {&step, &string_course, &cornice, &soffit})
        add_moulding(stone, half, *profile, 1.0);
    return {std::move(name), {stone.take()}};
}

Mesh shell_mesh(const Materials& m) {
    Shape paving(m.paving, 2.0);
    const double court_x = kFaceX - 0.29;
    const double court_z = kFaceZ - 0.29;
    add_quad(paving, {-court_x, 0, court_z}, {court_x, 0, court_z}, {court_x, 0, -court_z},
        {-court_x, 0, -court_z});
    Shape quarry(m.quarry, 1.0);
    const double in_x = kFaceX + 0.55;
    const double in_z = kFaceZ + 0.55;
    for (const Storey& storey : kStoreys) {
        const double y = storey.floor;
        for (const double side : {1.0, -1.0}) {
            add_quad(quarry, {-side * 15, y, side * 6}, {side * 15, y, side * 6},
                {side * in_x, y, side * in_z}, {-side * in_x, y, side * in_z});
            add_quad(quarry, {side * 15, y, side * 6}, {side * 15, y, -side * 6},
                {side * in_x, y, -side * in_z}, {side * in_x, y, side * in_z});
        }
    }
    constexpr double kEave = 9.55;
    constexpr double kRidge = 11.0;
    const double eave_x = kFaceX - 0.45;
    const double eave_z = kFaceZ - 0.45;
    constexpr double kRun = 4.2; // plan, eave to ridge; hips at 45 degrees
    Shape roof(m.roof);
    Shape brick(m.brick);
    Shape tiles(m.clay);
    for (const double side : {1.0, -1.0}) {
        const double x0 = side * eave_x, x1 = side * (eave_x + kRun);
        const double z0 = side * eave_z, z1 = side * (eave_z + kRun);
        add_quad(roof, {x0, kEave, z0}, {-x0, kEave, z0}, {-x1, kRidge, z1}, {x1, kRidge, z1});
        add_quad(roof, {x0, kEave, -z0}, {x0, kEave, z0}, {x1, kRidge, z1}, {x1, kRidge, -z1});
        add_quad(brick, {-x1, -0.3, z1}, {x1, -0.3, z1}, {x1, kRidge, z1}, {-x1, kRidge, z1});
        add_quad(brick, {x1, -0.3, z1}, {x1, -0.3, -z1}, {x1, kRidge, -z1}, {x1, kRidge, z1});
        // Rows of cover tiles from eave or hip up to the ridge.
        const auto add_row = [&](double along, double eave_along, auto&& point) {
            const double start = std::max(-0.06, std::abs(along) - eave_along);
            const auto height = [&](double run) {
                return kEave + 0.03 + (kRidge - kEave) * run / kRun;
            };
            if (start > kRun - 0.3) return;
            add_rod(tiles, point(start, height(start)), point(kRun, height(kRun)), 0.075, 8);
        };
        for (int i = -76; i <= 76; ++i)
            add_row(0.2 * i, eave_x, [&](double run, double y) {
                return glm::dvec3(0.2 * i, y, side * (eave_z + run));
            });
        for (int i = -31; i <= 31; ++i)
            add_row(0.2 * i, eave_z, [&](double run, double y) {
                return glm::dvec3(side * (eave_x + run), y, 0.2 * i);
            });
    }
    Shape coping(m.limestone);
    const double out_x = eave_x + kRun, out_z = eave_z + kRun;
    for (const double side : {1.0, -1.0}) {
        add_box(coping, {-out_x - 0.1, 10.9, side * out_z - 0.18},
            {out_x + 0.1, 11.14, side * out_z + 0.18});
        add_box(coping, {side * out_x - 0.17, 10.91, 0.1 - out_z},
            {side * out_x + 0.17, 11.13, out_z - 0.1});
    }
    Shape earth(m.earth);
    // Narrow, for shadow maps cover the bounds of a scene.
    add_quad(earth, {-17, -0.25, 8}, {17, -0.25, 8}, {17, -0.25, -8}, {-17, -0.25, -8});
    return {"shell", {paving.take(), quarry.take(), roof.take(), brick.take(), tiles.take(),
                         coping.take(), earth.take()}};
}

} // namespace ockham::atrium

// SPDX-License-Identifier: Apache-2.0
// A courtyard of 8 by 2 bays, open to the sky, inside a ring of 24 vaulted bays on two storeys.
// Every bay is 3 m square. The court's long axis is x; y is up; the origin is the court's centre.
#include "framework/core/rng.hpp"
#include "framework/scene/builtin_parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace ockham {

namespace {

constexpr double kBay = 3.0;
constexpr double kCourtX = 12.0; // column axes around the court
constexpr double kCourtZ = 3.0;
constexpr double kWall = 0.25;             // half the thickness of the court's walls
constexpr double kFaceX = kCourtX - kWall; // walls seen from the court
constexpr double kFaceZ = kCourtZ - kWall;
constexpr double kOuterX = 14.9; // inner face of the outer wall
constexpr double kOuterZ = 5.9;
constexpr double kArchRise = 1.8; // springing to the top of the arch wall
constexpr double kArchRadius = 1.25;
constexpr double kVaultRadius = 1.5;

struct Storey {
    double floor;     ///< metres
    double springing; ///< metres, top of the columns
};
constexpr std::array<Storey, 2> kStoreys{{{0.15, 2.95}, {5.05, 7.40}}};

struct Materials {
    int ashlar, brick, limestone, plaster, paving, quarry, roof, clay, wood, red, blue, leaf, bark;
    int iron, glass, water, earth;
};

Materials add_materials(Scene& scene) {
    Materials m{};
    m.ashlar = add_material(scene, "ashlar", ashlar_images(), 0.75f);
    m.brick = add_material(scene, "brick", brick_images(), 0.85f);
    m.limestone = add_material(scene, "limestone", limestone_images(), 0.6f);
    m.plaster = add_material(scene, "plaster", plaster_images(), 0.9f);
    m.paving = add_material(scene, "paving", paving_images(), 1.0f);
    m.quarry = add_material(scene, "quarry_tiles", quarry_images(), 0.5f);
    m.roof = add_material(scene, "roof_tiles", roof_images(), 0.8f);
    m.wood = add_material(scene, "wood", wood_images(), 0.6f);
    m.red = add_material(scene, "cloth_red", cloth_images(), 0.85f);
    m.leaf = add_material(scene, "sprig", sprig_images(), 0.55f);
    m.clay = add_material(scene, "clay", {0.62f, 0.30f, 0.17f}, 0.7f);
    m.blue = add_material(scene, "cloth_blue", {0.10f, 0.24f, 0.55f}, 0.85f);
    m.bark = add_material(scene, "bark", {0.16f, 0.11f, 0.07f}, 0.9f);
    m.iron = add_material(scene, "iron", {0.22f, 0.20f, 0.19f}, 0.42f);
    m.glass = add_material(scene, "lantern_glass", {0.8f, 0.7f, 0.5f}, 0.3f);
    m.water = add_material(scene, "water", {0.03f, 0.09f, 0.10f}, 0.3f);
    m.earth = add_material(scene, "earth", {0.22f, 0.17f, 0.12f}, 0.9f);

    auto& all = scene.materials;
    const auto share_images = [&](int to, int from) {
        all[to].base_color_texture = all[from].base_color_texture;
        all[to].normal_texture = all[from].normal_texture;
    };
    share_images(m.clay, m.limestone);
    share_images(m.blue, m.red);
    all[m.red].base_color = {0.62f, 0.06f, 0.05f, 1.0f};
    for (const int cloth : {m.red, m.blue}) all[cloth].double_sided = true;
    all[m.leaf].double_sided = true;
    all[m.leaf].masked = true;
    TextureUse& twig = all[m.leaf].base_color_texture;
    twig.wrap_u = twig.wrap_v = Wrap::clamp;
    all[m.iron].metallic = 1.0f;
    all[m.glass].emissive = {4.5f, 2.9f, 1.3f};
    return m;
}

/// A bay or a support: where it stands, and the turn that makes local +z look to the court (or,
/// for outer walls, into the aisle).
struct Place {
    double x, z, turns;
};

std::vector<Place> court_bays() {
    std::vector<Place> places;
    for (double x = -10.5; x < 11.0; x += kBay) {
        places.push_back({x, -kCourtZ, 0.0});
        places.push_back({x, kCourtZ, 0.5});
    }
    for (const double z : {-1.5, 1.5}) {
        places.push_back({-kCourtX, z, 0.25});
        places.push_back({kCourtX, z, 0.75});
    }
    return places;
}

std::vector<Place> court_columns() {
    std::vector<Place> places;
    for (double x = -kCourtX; x <= kCourtX; x += kBay)
        for (const double z : {-kCourtZ, kCourtZ}) places.push_back({x, z, 0.0});
    for (const double x : {-kCourtX, kCourtX}) places.push_back({x, 0.0, 0.0});
    return places;
}

std::vector<Place> aisle_bays() {
    std::vector<Place> places;
    for (double x = -13.5; x < 14.0; x += kBay)
        for (const double z : {-4.5, 4.5}) places.push_back({x, z, 0.0});
    for (const double x : {-13.5, 13.5})
        for (const double z : {-1.5, 1.5}) places.push_back({x, z, 0.0});
    return places;
}

/// Along the outer wall at multiples of a bay, moved by `offset` bays: 0.5 gives the walls'
/// middles, 0 the pilasters and transverse arches between them.
std::vector<Place> outer_places(double offset) {
    std::vector<Place> places;
    for (double x = -15.0 + kBay * offset; x < 15.0; x += kBay) {
        if (x == -15.0) continue;
        places.push_back({x, -kOuterZ, 0.0});
        places.push_back({x, kOuterZ, 0.5});
    }
    for (double z = -6.0 + kBay * offset; z < 6.0; z += kBay) {
        if (z == -6.0) continue;
        places.push_back({-kOuterX, z, 0.25});
        places.push_back({kOuterX, z, 0.75});
    }
    return places;
}

void place_all(Scene& scene, int mesh, const std::vector<Place>& places, double y) {
    for (const Place& place : places)
        add_instance(scene, mesh, placement({place.x, y, place.z}, place.turns));
}

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

/// Wall of one bay over an arch, springing at y = 0, with moulded arch and keystone.
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

/// Turned column on a square plinth, its abacus ending at y = height.
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

/// Flat pier before the outer wall (local z = 0), its top at y = height.
Mesh pilaster_mesh(const Materials& m, std::string name, double height) {
    Shape stone(m.limestone);
    add_box(stone, {-0.28, -0.03, -0.05}, {0.28, 0.24, 0.24});
    add_box(stone, {-0.22, 0.20, -0.06}, {0.22, height - 0.1, 0.17});
    add_box(stone, {-0.25, height - 0.2, -0.07}, {0.25, height - 0.13, 0.205});
    add_box(stone, {-0.29, height - 0.14, -0.05}, {0.29, height + 0.01, 0.25});
    return {std::move(name), {stone.take()}};
}

/// Groin vault of one bay, springing at y = 0, with diagonal ribs and a boss.
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

/// Transverse arch between a pier at the outer wall (local z = 0) and a column 2.9 m before it.
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

/// Outer wall of one bay seen from the aisle, 4.6 m high, with dado; `door` puts a door into it.
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
        for (const double y : {0.15, 0.95, 1.9})
            add_box(wood, {-0.57, y, 0.06}, {0.57, y + 0.14, 0.16});
        mesh.primitives.push_back(wood.take());
        Shape iron(m.iron);
        add_rod(iron, {0.42, 1.16, 0.12}, {0.42, 1.16, 0.22}, 0.02, 8);
        add_rod(iron, {0.42, 1.05, 0.21}, {0.42, 1.27, 0.21}, 0.015, 8);
        mesh.primitives.push_back(iron.take());
    }
    mesh.primitives.push_back(face.take());
    mesh.primitives.push_back(dado.take());
    mesh.primitives.push_back(stone.take());
    return mesh;
}

/// Balustrade of one bay between two columns, standing on y = 0.
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

/// Small blocks under the cornice, one bay.
Mesh dentil_mesh(const Materials& m) {
    Shape stone(m.limestone);
    for (int i = 0; i < 10; ++i) { // 0.3 m apart: none stands half in a corner of the court
        const double x = (i - 4.5) * 0.3;
        add_box(stone, {x - 0.065, 9.13, 0.22}, {x + 0.065, 9.225, kWall + 0.13});
    }
    return {"dentils", {stone.take()}};
}

/// Link of a chain: a ring stretched along `along`, flat in the plane of `along` and `across`.
constexpr double kLinkPitch = 0.083; // inner length, so that neighbours touch
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

/// Chain across the court along z, hung up at z = +-half, y = 0; sags by `sag`. Returns nothing:
/// the lowest link is at z = 0.
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

constexpr double kLanternDrop = 0.40; // hook to the middle of the glass

/// Lantern that hangs from y = 0 on `links` of chain above it.
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

/// Banner that hangs from a rod at y = 0, z = 0.25 before a balustrade at z = -0.25.
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

/// A leaf card: a square of twig texture, bent downwards, from `base` along `along`, its face
/// towards `face`.
void add_sprig(Shape& shape, glm::dvec3 base, glm::dvec3 along, glm::dvec3 face, double size) {
    along = glm::normalize(along);
    const glm::dvec3 right = glm::normalize(glm::cross(along, face));
    const glm::dvec3 normal = glm::cross(right, along);
    add_grid(shape, 1, 3, [&](int i, int j) {
        const double t = 1.0 - j / 3.0; // from base to tip
        const double bend = 0.22 * t * t;
        return ShapeVertex{base + size * (right * (i - 0.5) + along * t - normal * bend),
            normal + along * (0.44 * t), right, {double(i), 1.0 - t}};
    });
}

glm::dvec3 random_direction(Pcg32& rng) {
    for (;;) {
        const double x = rng.uniform(-1.0f, 1.0f);
        const double y = rng.uniform(-1.0f, 1.0f);
        const double z = rng.uniform(-1.0f, 1.0f);
        const double square = x * x + y * y + z * z;
        if (square > 0.05 && square < 1.0) return glm::dvec3(x, y, z) / std::sqrt(square);
    }
}

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

/// Pot with earth, plant of `leaves` cards; `trunk` metres of stem lift the crown.
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

/// Creeper that hangs over a balustrade (its outer face at z = 0) from y = 0 downwards.
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

/// Cornices and steps that run around the court, for a wall of the given half length.
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

/// Floors, roof, and the outer shell: everything that is made once.
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
    add_quad(earth, {-60, -0.25, 50}, {60, -0.25, 50}, {60, -0.25, -50}, {-60, -0.25, -50});
    return {"shell", {paving.take(), quarry.take(), roof.take(), brick.take(), tiles.take(),
                         coping.take(), earth.take()}};
}

int add(Scene& scene, Mesh mesh) { return add_mesh(scene, mesh.name, std::move(mesh.primitives)); }

void add_architecture(Scene& scene, const Materials& m) {
    add_instance(scene, add(scene, shell_mesh(m)));
    const int long_bands = add(scene, bands_mesh(m, "bands_long", kFaceX));
    const int short_bands = add(scene, bands_mesh(m, "bands_short", kFaceZ));
    place_all(scene, long_bands, {{0, -kFaceZ, 0.0}, {0, kFaceZ, 0.5}}, 0.0);
    place_all(scene, short_bands, {{-kFaceX, 0, 0.25}, {kFaceX, 0, 0.75}}, 0.0);

    const int arch = add(scene, arch_mesh(m));
    const int vault = add(scene, vault_mesh(m));
    const int transverse = add(scene, transverse_mesh(m));
    const std::array columns{
        add(scene, column_mesh(m, "column_lower", kStoreys[0].springing - kStoreys[0].floor, 0.22)),
        add(scene,
            column_mesh(m, "column_upper", kStoreys[1].springing - kStoreys[1].floor, 0.18))};
    const std::array pilasters{
        add(scene, pilaster_mesh(m, "pilaster_lower", kStoreys[0].springing - kStoreys[0].floor)),
        add(scene, pilaster_mesh(m, "pilaster_upper", kStoreys[1].springing - kStoreys[1].floor))};
    const std::array walls{add(scene, outer_wall_mesh(m, "wall_lower", m.brick, 1.0, false)),
        add(scene, outer_wall_mesh(m, "wall_upper", m.plaster, 3.0, false))};
    const std::array doors{add(scene, outer_wall_mesh(m, "door_lower", m.brick, 1.0, true)),
        add(scene, outer_wall_mesh(m, "door_upper", m.plaster, 3.0, true))};
    for (std::size_t s = 0; s < kStoreys.size(); ++s) {
        const Storey& storey = kStoreys[s];
        place_all(scene, arch, court_bays(), storey.springing);
        place_all(scene, vault, aisle_bays(), storey.springing);
        place_all(scene, transverse, outer_places(0.0), storey.springing);
        place_all(scene, columns[s], court_columns(), storey.floor);
        place_all(scene, pilasters[s], outer_places(0.0), storey.floor);
        int number = 0;
        for (const Place& place : outer_places(0.5))
            place_all(scene, number++ % 4 < 2 ? walls[s] : doors[s], {place}, storey.floor);
    }
    // The walls are hollow and end at the corner columns' axes: a core closes them.
    Shape core(m.limestone);
    constexpr double kCore = kWall - 0.005;
    add_box(core, {-kCore, 0, -kCore}, {kCore, kArchRise, kCore});
    const int corner = add_mesh(scene, "corner_core", core);
    for (const Storey& storey : kStoreys)
        for (const double x : {-kCourtX, kCourtX})
            for (const double z : {-kCourtZ, kCourtZ})
                add_instance(scene, corner, placement({x, storey.springing, z}));
    place_all(scene, add(scene, balustrade_mesh(m)), court_bays(), kStoreys[1].floor);
    place_all(scene, add(scene, dentil_mesh(m)), court_bays(), 0.0);
}

void add_lantern_light(Scene& scene, glm::dvec3 hook, Pcg32& rng) {
    Light light;
    light.name = fmt::format("lantern_{}", scene.lights.size());
    light.position = placement(hook - glm::dvec3(0, kLanternDrop, 0))[3];
    light.intensity = {rng.uniform(1.9f, 2.2f), rng.uniform(1.35f, 1.6f), rng.uniform(1.0f, 1.15f)};
    light.range = 6.0f;
    light.window_power = 2.0f;
    light.softening = 0.1f;
    scene.lights.push_back(std::move(light));
}

/// 12 lanterns below every other vault of the lower storey, 9 of the upper, 3 over the court.
void add_lanterns(Scene& scene, const Materials& m) {
    constexpr int kLinks = 13;
    Pcg32 rng(25);
    const int hanging = add(scene, lantern_mesh(m, "lantern_hanging", kLinks));
    const int short_lantern = add(scene, lantern_mesh(m, "lantern_court", 4));
    const auto hang = [&](int mesh, glm::dvec3 hook) {
        add_instance(scene, mesh, placement(hook));
        add_lantern_light(scene, hook, rng);
    };
    for (std::size_t s = 0; s < kStoreys.size(); ++s)
        for (const Place& bay : aisle_bays()) {
            const int number = static_cast<int>((bay.x + 13.5 + bay.z + 4.5) / kBay + 0.5);
            if (number % 2 != static_cast<int>(s)) continue;
            if (s == 1 && std::abs(bay.x) > 13.0 && bay.z > -4.0) continue;
            const double crown = kStoreys[s].springing + kVaultRadius - 0.15;
            hang(hanging, {bay.x, crown - kLinks * kLinkPitch, bay.z});
        }
    Shape chain(m.iron);
    constexpr double kSag = 1.1;
    add_slack_chain(chain, kCourtZ - 0.1, kSag);
    const int slack = add_mesh(scene, "chain_court", chain);
    for (const double x : {-6.0, 0.0, 6.0}) {
        add_instance(scene, slack, placement({x, 6.75, 0}));
        hang(short_lantern, {x, 6.75 - kSag - 4 * kLinkPitch - 0.02, 0});
    }
}

void add_furniture(Scene& scene, const Materials& m) {
    add_instance(scene, add(scene, fountain_mesh(m)), placement({1.5, 0, 0}));

    const std::array banners{add(scene, banner_mesh(m, "banner_red", m.red)),
        add(scene, banner_mesh(m, "banner_blue", m.blue))};
    const double rail = kStoreys[1].floor + 0.93;
    int number = 0;
    for (const double x : {-7.5, -1.5, 4.5, 10.5})
        for (const double side : {1.0, -1.0}) {
            const Place place{
                side > 0.0 ? x : x - 3.0, side * (kCourtZ - 0.26), side > 0.0 ? 0.5 : 0.0};
            place_all(scene, banners[(number / 2 + number) % 2], {place}, rail);
            ++number;
        }

    const int creeper = add(scene, creeper_mesh(m));
    for (const auto& [x, side] :
        {std::pair{-4.5, 1.0}, {-7.5, -1.0}, {1.5, 1.0}, {4.5, -1.0}, {7.5, 1.0}, {10.5, -1.0}})
        place_all(scene, creeper, {{x, side * (kCourtZ - 0.40), side > 0.0 ? 0.5 : 0.0}},
            kStoreys[1].floor + 0.95);

    const std::array plants{add(scene, planter_mesh(m, "tree", 1.05, 0.62, 150, 3)),
        add(scene, planter_mesh(m, "shrub", 0.0, 0.50, 90, 4))};
    number = 0;
    for (const double x : {-9.0, -6.0, -3.0, 6.0, 9.0})
        for (const double side : {-1.0, 1.0}) {
            const int kind = (number / 2 + (side > 0.0 ? 1 : 0)) % 2;
            add_instance(scene, plants[kind], placement({x, 0, side * 2.0}, 0.173 * number));
            ++number;
        }
}

} // namespace

Scene builtin_atrium() {
    Scene scene;
    const Materials materials = add_materials(scene);
    add_sun(scene, {0.42f, 1.0f, -0.34f}, {6.5f, 6.0f, 5.2f});
    add_architecture(scene, materials);
    add_lanterns(scene, materials);
    add_furniture(scene, materials);
    add_camera(scene, "court", {-11.3f, 2.3f, 0.55f}, {8.0f, 3.7f, -0.5f}, 65.0f);
    add_camera(scene, "foliage", {-8.3f, 5.2f, 0.3f}, {-5.3f, 5.45f, 2.2f}, 55.0f);
    add_camera(scene, "up", {-5.0f, 1.7f, -1.2f}, {2.5f, 8.2f, 1.0f}, 75.0f);
    scene.background = {0.35f, 0.55f, 0.9f};
    scene.ambient = {0.13f, 0.14f, 0.16f};
    return scene;
}

} // namespace ockham

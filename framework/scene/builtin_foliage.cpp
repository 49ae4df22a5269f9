// SPDX-License-Identifier: Apache-2.0
// A meadow with trees and shrubs: leaves, cut out by alpha, and thin branches before sky and
// ground. Nearly every pixel holds an edge, so it is the dearest picture for adaptive methods.
#include "framework/scene/builtin_parts.hpp"

#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace ockham {

namespace {

struct Materials {
    int meadow, bark, leaf, blades;
};

Materials add_materials(Scene& scene) {
    Materials m{};
    m.meadow = add_material(scene, "meadow", meadow_images(), 0.95f);
    m.bark = add_material(scene, "bark", {0.20f, 0.15f, 0.11f}, 0.9f);
    m.leaf = add_material(scene, "leaf", sprig_images(), 0.5f);
    m.blades = add_material(scene, "blades", blades_images(), 0.7f);
    for (const int cut_out : {m.leaf, m.blades}) {
        Material& material = scene.materials[cut_out];
        material.masked = material.double_sided = true;
        material.base_color_texture.wrap_u = material.base_color_texture.wrap_v = Wrap::clamp;
    }
    return m;
}

/// A piece of wood: its axis from the foot to the tip.
struct Branch {
    std::vector<glm::dvec3> axis;
    double foot_radius, tip_radius; ///< metres

    glm::dvec3 at(double t) const { // 0 foot ... 1 tip
        const double place = t * (double(axis.size()) - 1.0);
        const auto i = std::min(static_cast<std::size_t>(place), axis.size() - 2);
        return glm::mix(axis[i], axis[i + 1], place - double(i));
    }
    glm::dvec3 direction(double t) const {
        const auto i =
            std::min(static_cast<std::size_t>(t * (double(axis.size()) - 1.0)), axis.size() - 2);
        return glm::normalize(axis[i + 1] - axis[i]);
    }
};

/// Grows from `foot`, wandering, and bent towards `toward`.
Branch grow(glm::dvec3 foot, glm::dvec3 direction, double length, int pieces, double wander,
    glm::dvec3 toward, double foot_radius, Pcg32& rng) {
    Branch branch{{foot}, foot_radius, 0.25 * foot_radius};
    for (int i = 0; i < pieces; ++i) {
        direction =
            glm::normalize(direction + wander * random_direction(rng) + toward / double(pieces));
        branch.axis.push_back(branch.axis.back() + direction * (length / pieces));
    }
    return branch;
}

void add_wood(Shape& shape, const Branch& branch, int sides) {
    const int rings = static_cast<int>(branch.axis.size()) - 1;
    // Carried along the axis, so that neighbouring rings are not turned against each other.
    glm::dvec3 side =
        std::abs(branch.direction(0).x) > 0.8 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0);
    std::vector<glm::dvec3> side_at;
    for (int j = 0; j <= rings; ++j) {
        const glm::dvec3 along = branch.direction(double(j) / rings);
        side = glm::normalize(side - along * glm::dot(side, along));
        side_at.push_back(side);
    }
    add_grid(shape, sides, rings, [&](int i, int j) {
        const double t = 1.0 - double(j) / rings; // from the tip down
        const glm::dvec3 across = side_at[rings - j];
        const glm::dvec3 front = glm::cross(across, branch.direction(t));
        const glm::dvec2 a = unit_at(double(i) / sides);
        const glm::dvec3 out = across * a.x - front * a.y;
        const double radius = glm::mix(branch.foot_radius, branch.tip_radius, t);
        return ShapeVertex{branch.at(t) + out * radius, out, -front * a.x - across * a.y,
            {double(i) / sides, double(j) / rings}};
    });
}

/// Twigs along the outer part of a branch.
void add_leaves(Shape& leaves, const Branch& branch, int count, double size, Pcg32& rng) {
    for (int i = 0; i < count; ++i) {
        const double t = 0.25 + 0.75 * (i + double{rng.uniform()}) / count;
        const glm::dvec3 along = branch.direction(t) + 0.9 * random_direction(rng);
        const glm::dvec3 face = glm::dvec3(0, 1, 0) + 0.9 * random_direction(rng);
        add_sprig(leaves, branch.at(t), along, face, size * (0.75 + 0.5 * rng.uniform()));
    }
}

struct TreeForm {
    double trunk;      ///< metres
    double spread;     ///< length of the lowest boughs, metres
    double rise;       ///< how much boughs point up
    int boughs, twigs; ///< boughs of the trunk, branches of each bough
    int leaves;        ///< cards of each branch
    std::uint64_t seed;
};

Mesh tree_mesh(const Materials& m, std::string name, const TreeForm& form) {
    Pcg32 rng(form.seed);
    Shape wood(m.bark), leaves(m.leaf);
    const Branch trunk =
        grow({0, -0.1, 0}, {0, 1, 0}, form.trunk, 8, 0.07, {0, 0.3, 0}, 0.035 * form.trunk, rng);
    add_wood(wood, trunk, 10);
    for (int b = 0; b < form.boughs; ++b) {
        const double t = 0.30 + 0.68 * (b + 0.5) / form.boughs;
        const glm::dvec2 a = unit_at(0.382 * b + 0.06 * rng.uniform()); // golden section: all round
        const double length = form.spread * (1.15 - 0.75 * t) * (0.85 + 0.3 * rng.uniform());
        const Branch bough = grow(trunk.at(t), {a.x, form.rise, a.y}, length, 5, 0.16, {0, 0.25, 0},
            0.03 * length + 0.004, rng);
        add_wood(wood, bough, 7);
        for (int i = 0; i < form.twigs; ++i) {
            const double s = 0.22 + 0.75 * (i + 0.5) / form.twigs;
            const glm::dvec3 out = bough.direction(s) + 0.85 * random_direction(rng);
            const Branch twig = grow(bough.at(s), glm::normalize(out),
                0.32 * length * (1.2 - 0.5 * s), 3, 0.2, {0, 0.1, 0}, 0.009, rng);
            add_wood(wood, twig, 4);
            add_leaves(leaves, twig, form.leaves, 0.34, rng);
        }
    }
    return {std::move(name), {wood.take(), leaves.take()}};
}

Mesh shrub_mesh(const Materials& m) {
    Pcg32 rng(77);
    Shape wood(m.bark), leaves(m.leaf);
    for (int i = 0; i < 16; ++i) {
        const glm::dvec2 a = unit_at(0.382 * i);
        const Branch stem = grow({0.1 * a.x, -0.05, 0.1 * a.y}, {a.x, 1.1, a.y},
            0.55 + 0.4 * rng.uniform(), 4, 0.2, {0, 0, 0}, 0.012, rng);
        add_wood(wood, stem, 4);
        add_leaves(leaves, stem, 9, 0.24, rng);
    }
    return {"shrub", {wood.take(), leaves.take()}};
}

/// Tufts of grass over 2 m by 2 m, two crossed cards each.
Mesh grass_mesh(const Materials& m) {
    Pcg32 rng(78);
    Shape blades(m.blades);
    for (int tuft = 0; tuft < 48; ++tuft) {
        const glm::dvec3 foot{rng.uniform(-1.0f, 1.0f), -0.02, rng.uniform(-1.0f, 1.0f)};
        const double height = rng.uniform(0.16f, 0.34f);
        const double turn = rng.uniform();
        for (const double quarter : {0.0, 0.25}) {
            const glm::dvec2 a = unit_at(turn + quarter);
            const glm::dvec3 right(0.6 * height * a.x, 0, 0.6 * height * a.y);
            const glm::dvec3 normal(-a.y, 0.0, a.x);
            add_grid(blades, 1, 1, [&](int i, int j) {
                const double up = 1.0 - j;
                return ShapeVertex{foot + right * (2.0 * i - 1.0) + glm::dvec3(0, height * up, 0) +
                                       normal * (0.15 * height * up),
                    normal + glm::dvec3(0, 0.4, 0), right, {double(i), double(j)}};
            });
        }
    }
    return {"grass", {blades.take()}};
}

} // namespace

Scene builtin_foliage() {
    Scene scene;
    const Materials m = add_materials(scene);
    const auto add = [&](Mesh mesh) {
        return add_mesh(scene, mesh.name, std::move(mesh.primitives));
    };
    Shape ground(m.meadow, 4.0);
    add_quad(ground, {-30, 0, 20}, {30, 0, 20}, {30, 0, -40}, {-30, 0, -40});
    add_instance(scene, add_mesh(scene, "ground", ground));

    const std::array trees{add(tree_mesh(m, "broad_tree", {3.6, 2.5, 0.55, 15, 9, 7, 71})),
        add(tree_mesh(m, "slender_tree", {4.6, 1.8, 1.0, 16, 8, 7, 74}))};
    struct Place {
        double x, z, turns, scale;
        int kind;
    };
    for (const Place& p : {Place{-2.4, -3.0, 0.0, 1.0, 0}, {2.9, -4.5, 0.3, 1.0, 1},
             {0.6, -11.0, 0.6, 1.1, 0}, {-7.5, -10.0, 0.2, 1.2, 1}, {7.0, -14.0, 0.8, 1.3, 0},
             {-2.0, -22.0, 0.4, 1.4, 1}, {-12.0, -24.0, 0.9, 1.5, 0}, {13.0, -26.0, 0.1, 1.5, 1}})
        add_instance(scene, trees[p.kind], placement({p.x, 0, p.z}, p.turns, p.scale));

    Pcg32 rng(79);
    const int shrub = add(shrub_mesh(m));
    const int grass = add(grass_mesh(m));
    for (int i = 0; i < 14; ++i) {
        const glm::dvec3 place{rng.uniform(-9.0f, 9.0f), 0.0, rng.uniform(-26.0f, -1.0f)};
        const double turns = rng.uniform();
        add_instance(scene, shrub, placement(place, turns, 0.8 + 0.7 * rng.uniform()));
    }
    for (int i = 0; i < 60; ++i) { // rows of patches, the nearer the denser
        const double z = 3.5 - 0.42 * i - 0.004 * i * i;
        const glm::dvec3 place{rng.uniform(-1.0f, 1.0f) * (2.5 + 0.2 * i), 0.0, z};
        add_instance(scene, grass, placement(place, rng.uniform()));
    }
    add_sun(scene, {0.55f, 1.0f, 0.35f}, {4.6f, 4.3f, 3.8f});
    add_camera(scene, "meadow", {0.0f, 1.6f, 4.5f}, {0.0f, 2.0f, -6.0f}, 60.0f);
    add_camera(scene, "crown", {-1.4f, 1.5f, -0.6f}, {-2.4f, 3.2f, -3.0f}, 60.0f);
    add_camera(scene, "grass", {0.6f, 0.45f, 3.2f}, {0.2f, 0.3f, -4.0f}, 50.0f);
    scene.background = {0.35f, 0.55f, 0.9f};
    scene.ambient = {0.20f, 0.22f, 0.24f};
    return scene;
}

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
// A show room at night: bumpy surfaces of low roughness, flat and curved, under small lamps. Their
// highlights are smaller than a pixel nearly everywhere, so few samples find them.
#include "framework/scene/builtin_parts.hpp"

#include <fmt/format.h>

#include <array>
#include <utility>

namespace ockham {

namespace {

struct Materials {
    int stone, flakes, copper, lacquer, silver, plinth, lamp;
};

Materials add_materials(Scene& scene) {
    Materials m{};
    m.stone = add_material(scene, "wet_stone", ripple_images(), 0.14f);
    m.flakes = add_material(scene, "flake_paint", flake_images(), 0.16f);
    m.copper = add_material(scene, "hammered_copper", hammered_images(), 0.16f);
    m.lacquer = add_material(scene, "lacquer", glm::vec3(0.35f, 0.02f, 0.02f), 0.10f);
    m.silver = add_material(scene, "silver_flakes", glm::vec3(0.75f, 0.75f, 0.78f), 0.14f);
    m.plinth = add_material(scene, "plinth", glm::vec3(0.45f), 0.8f);
    m.lamp = add_material(scene, "lamp", glm::vec3(0.8f), 0.5f);
    auto& all = scene.materials;
    all[m.stone].base_color = {0.55f, 0.58f, 0.65f, 1.0f};
    all[m.flakes].base_color = {0.02f, 0.05f, 0.20f, 1.0f};
    all[m.flakes].ior = 1.8f;
    all[m.copper].base_color = {0.90f, 0.52f, 0.36f, 1.0f};
    all[m.copper].metallic = 1.0f;
    all[m.lacquer].normal_texture = all[m.copper].normal_texture;
    all[m.lacquer].normal_scale = 0.35f;
    all[m.silver].normal_texture = all[m.flakes].normal_texture;
    all[m.silver].metallic = 1.0f;
    all[m.lamp].emissive = {9.0f, 7.5f, 5.5f};
    return m;
}

/// Standing on y = 0.
void add_ball(Shape& shape, double radius) {
    constexpr int kRings = 32;
    Profile arc;
    for (int i = 0; i <= kRings; ++i) {
        const glm::dvec2 a = unit_at(-0.25 + 0.5 * i / kRings);
        arc.points.emplace_back(a.x * radius, radius + a.y * radius);
    }
    add_lathe(shape, glm::dvec3(0), arc, 2 * kRings);
}

/// 1.1 m high, standing on y = 0.
void add_vase(Shape& shape) {
    Profile vase;
    vase.points = {{0.20, 0.0}, {0.21, 0.03}, {0.19, 0.06}, {0.24, 0.14}, {0.31, 0.26},
        {0.36, 0.40}, {0.37, 0.52}, {0.34, 0.65}, {0.27, 0.77}, {0.18, 0.87}, {0.13, 0.94},
        {0.13, 1.00}, {0.16, 1.06}, {0.21, 1.10}, {0.19, 1.09}, {0.12, 1.00}};
    add_lathe(shape, glm::dvec3(0), vase, 48);
}

void add_lamp(Scene& scene, int mesh, glm::dvec3 position, glm::vec3 intensity) {
    add_instance(scene, mesh, placement(position));
    Light light;
    light.name = fmt::format("lamp_{}", scene.lights.size());
    light.position = position;
    light.intensity = intensity;
    light.softening = 0.1f;
    scene.lights.push_back(std::move(light));
}

} // namespace

Scene builtin_sparkle() {
    Scene scene;
    const Materials m = add_materials(scene);
    add_sun(scene, {-0.5f, 0.8f, 0.35f}, {0.55f, 0.60f, 0.75f}); // the moon

    Shape floor(m.stone, 2.0);
    add_quad(floor, {-16, 0, 10}, {16, 0, 10}, {16, 0, -30}, {-16, 0, -30});
    add_instance(scene, add_mesh(scene, "floor", floor));
    Shape wall(m.flakes, 0.5);
    add_box(wall, {-3.6, 0.2, -3.3}, {3.6, 2.9, -3.0});
    add_instance(scene, add_mesh(scene, "wall", wall));

    Shape block(m.plinth);
    add_box(block, {-0.45, -0.1, -0.45}, {0.45, 0.5, 0.45});
    const int plinth = add_mesh(scene, "plinth", block);
    Shape copper(m.copper, 0.5), silver(m.silver, 0.5), lacquer(m.lacquer, 0.5);
    add_ball(copper, 0.55);
    add_ball(silver, 0.45);
    add_vase(lacquer);
    const std::array pieces{add_mesh(scene, "copper_ball", copper),
        add_mesh(scene, "lacquer_vase", lacquer), add_mesh(scene, "silver_ball", silver)};
    for (int i = 0; i < 9; ++i) { // three near, the others in rows that recede
        const int row = i / 3;
        const double x = (i % 3 - 1) * (1.5 + 1.1 * row) + (row == 1 ? 5.2 : row == 2 ? -7.0 : 0.0);
        const double z = -0.6 - 5.5 * row;
        add_instance(scene, plinth, placement({x, 0, z}));
        add_instance(scene, pieces[(i + row) % 3], placement({x, 0.5 - 0.004, z}, 0.07 * i));
    }

    Shape bulb(m.lamp);
    add_ball(bulb, 0.03);
    const int lamp = add_mesh(scene, "lamp", bulb);
    Pcg32 rng(31);
    for (int i = 0; i < 12; ++i) {
        // Braces: the random numbers are drawn from left to right.
        const glm::dvec3 position{
            -4.4 + 0.8 * i, 2.9 + 0.9 * rng.uniform(), 1.6 - 7.0 * rng.uniform() + 3.0 * (i % 2)};
        const glm::vec3 intensity{
            rng.uniform(1.6f, 2.6f), rng.uniform(1.3f, 2.0f), rng.uniform(0.8f, 1.8f)};
        add_lamp(scene, lamp, position, intensity);
    }
    add_camera(scene, "room", {0.4f, 1.75f, 4.2f}, {0.0f, 1.0f, -3.0f}, 55.0f);
    add_camera(scene, "curved", {-1.1f, 1.3f, 1.2f}, {-1.5f, 1.05f, -0.6f}, 45.0f);
    add_camera(scene, "flat", {0.0f, 1.5f, -0.2f}, {1.2f, 1.2f, -3.0f}, 50.0f);
    scene.background = {0.010f, 0.014f, 0.030f};
    scene.ambient = {0.06f, 0.065f, 0.08f};
    return scene;
}

} // namespace ockham

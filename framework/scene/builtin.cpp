// SPDX-License-Identifier: Apache-2.0
#include "framework/scene/builtin.hpp"

#include "framework/core/error.hpp"
#include "framework/scene/builtin_parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>

namespace ockham {

int add_image(Scene& scene, TextureImage image) {
    if (image.rgba.empty()) return -1;
    scene.images.push_back(std::move(image));
    return static_cast<int>(scene.images.size()) - 1;
}

int add_material(Scene& scene, std::string name, glm::vec3 base_color, float roughness) {
    Material material;
    material.name = std::move(name);
    material.base_color = glm::vec4(base_color, 1.0f);
    material.metallic = 0.0f;
    material.roughness = roughness;
    scene.materials.push_back(std::move(material));
    return static_cast<int>(scene.materials.size()) - 1;
}

int add_material(Scene& scene, std::string name, SurfaceImages images, float roughness) {
    const int index = add_material(scene, std::move(name), glm::vec3(1.0f), roughness);
    const int color = add_image(scene, std::move(images.color));
    const int normal = add_image(scene, std::move(images.normal));
    const int metallic_roughness = add_image(scene, std::move(images.roughness));
    Material& material = scene.materials[index];
    material.base_color_texture.image = color;
    material.normal_texture.image = normal;
    material.metallic_roughness_texture.image = metallic_roughness;
    return index;
}

int add_mesh(Scene& scene, std::string name, std::vector<Primitive> primitives) {
    scene.meshes.push_back({std::move(name), std::move(primitives)});
    return static_cast<int>(scene.meshes.size()) - 1;
}

int add_mesh(Scene& scene, std::string name, Shape& shape) {
    return add_mesh(scene, std::move(name), std::vector{shape.take()});
}

void add_instance(Scene& scene, int mesh, const glm::mat4& world) {
    scene.instances.push_back({mesh, world});
}

void add_sun(Scene& scene, glm::vec3 toward, glm::vec3 irradiance) {
    Light sun;
    sun.name = "sun";
    sun.type = LightType::directional;
    sun.direction = glm::vec3(glm::normalize(-glm::dvec3(toward)));
    sun.intensity = irradiance;
    sun.casts_shadow = true;
    scene.lights.push_back(std::move(sun));
}

void add_camera(
    Scene& scene, std::string name, glm::vec3 position, glm::vec3 target, float fov_y_degrees) {
    const glm::dvec3 forward = glm::normalize(glm::dvec3(target) - glm::dvec3(position));
    const glm::dvec3 right = glm::normalize(glm::cross(forward, glm::dvec3(0, 1, 0)));
    Camera camera;
    camera.name = std::move(name);
    camera.position = position;
    camera.forward = forward;
    camera.up = glm::vec3(glm::cross(right, forward));
    camera.fov_y_degrees = fov_y_degrees;
    scene.cameras.push_back(std::move(camera));
}

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

namespace {

/// Black and white cells of 1 m to the horizon, unlit, so that radiance is exactly 0 or 1. The
/// background is their mean: whatever part of a pixel the horizon leaves free, 0.5 is right.
Scene plane() {
    constexpr double kReach = 2000.0; // whole cells, as many black as white
    Scene scene;
    const int material = add_material(scene, "checker", glm::vec3(1.0f), 1.0f);
    scene.materials[material].unlit = true;
    scene.materials[material].base_color_texture.image = add_image(scene, checker_image(64));
    Shape ground(material, 2.0);
    add_quad(ground, {-kReach, 0, kReach}, {kReach, 0, kReach}, {kReach, 0, -kReach},
        {-kReach, 0, -kReach});
    add_instance(scene, add_mesh(scene, "ground", ground));
    add_camera(scene, "horizon", {0, 1.6f, 0}, {0, 1.6f, -10}, 60.0f);
    scene.background = glm::vec3(0.5f);
    return scene;
}

/// Nothing but background.
Scene sky() {
    Scene scene;
    add_camera(scene, "up", {0, 0, 0}, {0, 2, -10}, 60.0f);
    scene.background = {0.35f, 0.55f, 0.9f};
    return scene;
}

/// Wheels of straight wires, one wheel per width, a row of wheels before the sky and one before a
/// white wall, and cables across both. From the camera a millimetre is a sixth of a pixel at 768
/// rows.
Scene wires() {
    constexpr std::array kWidths{0.5e-3, 1e-3, 2e-3, 3e-3, 5e-3, 8e-3, 12e-3, 20e-3};
    constexpr int kSpokes = 24;
    Scene scene;
    const int black = add_material(scene, "cable", glm::vec3(0.03f), 0.6f);
    const int white = add_material(scene, "wall", glm::vec3(0.7f), 0.9f);
    for (std::size_t w = 0; w < kWidths.size(); ++w) {
        Shape wheel(black);
        for (int spoke = 0; spoke < kSpokes; ++spoke) {
            // The fraction of a step keeps every spoke off the pixel grid's directions.
            const glm::dvec2 a = unit_at((spoke + 0.13) / kSpokes);
            const glm::dvec3 direction(a.x, a.y, 0.0);
            add_rod(wheel, direction * 0.09, direction * 0.29, 0.5 * kWidths[w], 12);
        }
        const int mesh = add_mesh(scene, fmt::format("wheel_{}mm", kWidths[w] * 1e3), wheel);
        const double x = (double(w) - 3.5) * 0.66;
        add_instance(scene, mesh, placement({x, 2.75, 0.0}));
        add_instance(scene, mesh, placement({x, 0.65, 0.0}));
    }
    Shape cables(black);
    for (std::size_t w = 0; w < kWidths.size(); ++w) {
        const double slope = 0.02 + 0.03 * double(w);
        const double above = 2.05 + 0.035 * double(w);
        const double below = 1.35 - 0.035 * double(w);
        add_rod(cables, {-4, above - 0.4 * slope, 0.05}, {4, above + 0.4 * slope, 0.05},
            0.5 * kWidths[w], 12);
        add_rod(cables, {-4, below + 0.4 * slope, 0.05}, {4, below - 0.4 * slope, 0.05},
            0.5 * kWidths[w], 12);
    }
    add_instance(scene, add_mesh(scene, "cables", cables));
    Shape wall(white);
    add_box(wall, {-5, -1, -0.6}, {5, 1.7, -0.3});
    add_instance(scene, add_mesh(scene, "wall", wall));
    add_sun(scene, {-0.4f, 1.0f, 0.9f}, {3.0f, 2.9f, 2.7f});
    add_camera(scene, "front", {0, 1.7f, 4}, {0, 1.7f, 0}, 60.0f);
    scene.background = {0.35f, 0.55f, 0.9f};
    scene.ambient = glm::vec3(0.25f);
    return scene;
}

constexpr double kPicketPanel = 2.4; // metres from post to post
constexpr double kLinkPanel = 2.56;
constexpr double kLinkHeight = 1.52;

/// One panel of picket fence along x, its face to +z: pointed boards and a post.
void add_pickets(Shape& shape) {
    constexpr int kPickets = 16;
    constexpr double kPitch = 0.15;
    constexpr double kWidth = 0.09;
    for (int i = 0; i < kPickets; ++i) {
        const double x = (i + 0.5) * kPitch;
        add_prism(shape,
            std::array<glm::dvec2, 5>{{{x - 0.5 * kWidth, 0.06}, {x + 0.5 * kWidth, 0.06},
                {x + 0.5 * kWidth, 0.92}, {x, 1.0}, {x - 0.5 * kWidth, 0.92}}},
            -0.01, 0.01);
    }
    add_box(shape, {-0.05, -0.1, -0.11}, {0.05, 0.95, -0.015});
}

/// One panel of chain-link along x: two sets of 3 mm wires at 45 degrees, and a post.
void add_chain_link(Shape& shape) {
    constexpr double kPitch = 0.08;
    for (double start = -kLinkHeight + 0.5 * kPitch; start < kLinkPanel; start += kPitch) {
        // A wire climbs one metre per metre from (start, 0) and is clipped to the panel; the
        // half millimetre keeps it off its continuation, behind the next post.
        const double low = std::max(0.0, -start);
        const double high = std::min(kLinkHeight, kLinkPanel - start) - 0.0005;
        const glm::dvec3 a(start + low, 0.04 + low, 0.0016);
        const glm::dvec3 b(start + high, 0.04 + high, 0.0016);
        add_rod(shape, a, b, 0.0015, 6);
        add_rod(shape, {kLinkPanel - a.x, a.y, -a.z}, {kLinkPanel - b.x, b.y, -b.z}, 0.0015, 6);
    }
    add_rod(shape, {0, -0.1, 0}, {0, 0.1 + kLinkHeight, 0}, 0.03, 16);
}

/// A picket fence on the left and a chain-link fence on the right run to the horizon.
Scene fence() {
    Scene scene;
    const int grass = add_material(scene, "ground", glm::vec3(0.30f, 0.32f, 0.20f), 0.9f);
    const int paint = add_material(scene, "paint", glm::vec3(0.80f), 0.6f);
    const int steel = add_material(scene, "galvanised", glm::vec3(0.42f, 0.44f, 0.46f), 0.5f);
    Shape ground(grass);
    add_quad(ground, {-1000, 0, 1000}, {1000, 0, 1000}, {1000, 0, -1000}, {-1000, 0, -1000});
    add_instance(scene, add_mesh(scene, "ground", ground));
    constexpr int kPanels = 80;
    Shape pickets(paint);
    add_pickets(pickets);
    const int picket_panel = add_mesh(scene, "pickets", pickets);
    Shape links(steel);
    add_chain_link(links);
    const int link_panel = add_mesh(scene, "chain_link", links);
    for (int i = 0; i < kPanels; ++i) { // along -z
        add_instance(scene, picket_panel, placement({-1.6, 0, -kPicketPanel * i}, 0.25));
        add_instance(scene, link_panel, placement({1.6, 0, -kLinkPanel * i}, 0.25));
    }
    Shape boards(paint);
    for (const double y : {0.25, 0.72})
        add_box(boards, {0, y, -0.05}, {kPanels * kPicketPanel, y + 0.08, -0.005});
    add_instance(scene, add_mesh(scene, "picket_rails", boards), placement({-1.6, 0, 0}, 0.25));
    Shape rail(steel);
    const double top = 0.04 + kLinkHeight;
    add_rod(rail, {0, top, 0}, {kPanels * kLinkPanel, top, 0}, 0.021, 12);
    add_instance(scene, add_mesh(scene, "chain_link_rail", rail), placement({1.6, 0, 0}, 0.25));
    add_sun(scene, {0.6f, 1.0f, 0.5f}, {5.0f, 4.7f, 4.2f});
    scene.lights.back().casts_shadow = false; // no shadow map resolves a wire over 2 km
    add_camera(scene, "between", {0, 1.3f, 0.5f}, {0, 1.0f, -10}, 60.0f);
    scene.background = {0.35f, 0.55f, 0.9f};
    scene.ambient = {0.15f, 0.17f, 0.20f};
    return scene;
}

struct Builder {
    BuiltinName about;
    Scene (*build)();
};

constexpr std::array<Builder, 7> kBuilders{{
    {{"atrium", "arcaded courtyard: stone, cloth, chains, foliage, a sun and 24 lanterns"},
        builtin_atrium},
    {{"fence", "picket and chain-link fences that run to the horizon"}, fence},
    {{"wires", "wires of 0.5 to 20 mm in all directions before sky and wall"}, wires},
    {{"sparkle", "bumpy metal, lacquer and wet stone under small lamps: highlights below a pixel"},
        builtin_sparkle},
    {{"foliage", "trees, shrubs and grass cut out by alpha, before sky and ground"},
        builtin_foliage},
    {{"plane", "black and white cells to the horizon, unlit"}, plane},
    {{"sky", "no geometry, background only"}, sky},
}};

} // namespace

const std::vector<BuiltinName>& builtin_scenes() {
    static const std::vector<BuiltinName> names = [] {
        std::vector<BuiltinName> result;
        for (const Builder& builder : kBuilders) result.push_back(builder.about);
        return result;
    }();
    return names;
}

Scene builtin_scene(std::string_view name) {
    std::string known;
    for (const Builder& builder : kBuilders) {
        if (builder.about.name == name) {
            Scene scene = builder.build();
            scene.name = name;
            return scene;
        }
        known += fmt::format("{}{}", known.empty() ? "" : ", ", builder.about.name);
    }
    fail_input("builtin scene: found no scene named '{}'; choose one of {}", name, known);
}

} // namespace ockham

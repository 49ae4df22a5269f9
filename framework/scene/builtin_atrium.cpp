// SPDX-License-Identifier: Apache-2.0
// A courtyard of 8 by 2 bays, open to the sky, inside a ring of 24 vaulted bays on two storeys.
// Every bay is 3 m square. The court's long axis is x; y is up; the origin is the court's centre.
#include "framework/core/rng.hpp"
#include "framework/scene/atrium_parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace ockham {

using namespace atrium;

namespace {

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

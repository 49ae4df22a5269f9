// SPDX-License-Identifier: Apache-2.0
// What a medium scatters meets the meshes around it: what they keep away and what they send,
// against quadrature; no light where none can be; nothing in the plan where nothing is scattered.
#include "framework/graph/explain/explain.hpp"
#include "passes/pipelines/surface_volume.hpp"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/surface_scenes.hpp"
#include "tests/support/z_test.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

namespace ockham::test {
namespace {

constexpr double kPi = std::numbers::pi;

/// A cube from -1/2 to 1/2, full of the same.
Volume cube() {
    Volume volume;
    volume.name = "cube";
    volume.dims = glm::uvec3(8);
    volume.voxels.assign(512, std::byte{255});
    return volume;
}
TransferFunction rising() { return {{{.value = 0, .opacity = 0}, {.value = 255, .opacity = 1}}}; }

/// No light but the environment's, if any.
VolumeView fog(float density, float albedo, float environment) {
    VolumeView view;
    view.environment = glm::vec3(environment);
    view.density_scale = density;
    view.albedo = albedo;
    return view;
}

Material matte(float albedo) {
    Material material;
    material.base_color = glm::vec4(glm::vec3(albedo), 1.0f);
    material.metallic = 0;
    material.ior = 1; // no reflection besides Lambert's
    material.double_sided = true;
    return material;
}

SurfaceVolumeParams params(std::uint32_t size, VolumeMode mode) {
    SurfaceVolumeParams p;
    p.surfaces.method = AaMethod::none;
    p.surfaces.m = 1;
    p.medium.width = p.medium.height = size;
    p.medium.mode = mode;
    p.medium.sobol = false;
    return p;
}

/// Parallel rays along -z close to the middle of the cube.
Camera through_the_middle() {
    Camera camera = look_at({0, 0, 5}, {0, 0, 0}, 30);
    camera.orthographic_height = 0.01f;
    return camera;
}

/// Radiance along that ray of light that is scattered once, where `radiance(p, w)` arrives at the
/// cube from direction w of a point p in it.
double scattered_once(double density, double albedo,
    const std::function<double(const glm::dvec3& p, const glm::dvec3& w)>& radiance) {
    constexpr int kSteps = 32, kRows = 200, kColumns = 400;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) {
        const double depth = (i + 0.5) / kSteps;
        const glm::dvec3 p(0, 0, 0.5 - depth);
        double around = 0;
        for (int row = 0; row < kRows; ++row) {
            for (int column = 0; column < kColumns; ++column) {
                const double y = 1 - 2 * (row + 0.5) / kRows, across = std::sqrt(1 - y * y);
                const double azimuth = 2 * kPi * (column + 0.5) / kColumns;
                const glm::dvec3 w(across * std::cos(azimuth), y, across * std::sin(azimuth));
                const glm::dvec3 walls = (glm::sign(w) * 0.5 - p) / w;
                const double exit = std::min({walls.x, walls.y, walls.z});
                around += std::exp(-density * exit) * radiance(p, w);
            }
        }
        sum += density * std::exp(-density * depth) * albedo * around / (kRows * kColumns);
    }
    return sum / kSteps;
}

class MeshTransportTest : public GpuTest {
protected:
    static Image render(const Scene& scene, const VolumeView& view, const Camera& camera,
        const SurfaceVolumeParams& p, int steps) {
        const LitScene lit(device(), scene);
        const Volume volume = cube();
        const Image none;
        SurfaceVolume picture(
            device(), &lit, MediumSource{volume, rising(), none, view, {}}, camera, p);
        for (int i = 0; i < steps; ++i) picture.execute();
        picture.finish();
        return picture.picture();
    }
    /// Of pictures whose pixels all show the same.
    static Estimate mean_of(const Image& picture) {
        double sum = 0, square = 0;
        for (const float value : picture.plane(1)) sum += value, square += double{value} * value;
        const auto n = static_cast<double>(picture.pixels());
        const double mean = sum / n;
        return {mean, std::sqrt((square / n - mean * mean) / (n - 1))};
    }
};

TEST_F(MeshTransportTest, APlateKeepsLightFromBelowAwayAndSendsItsOwn) {
    // A black half plane below the cube, and one that shines in the dark.
    const double density = 2, albedo = 0.8;
    const auto blocked = [](const glm::dvec3& p, const glm::dvec3& w) {
        if (w.y >= 0) return false;
        const glm::dvec3 at = p + w * ((-0.6 - p.y) / w.y);
        return at.x < 0.1 && at.x > -99.9 && std::abs(at.z) < 100;
    };
    for (const bool shines : {false, true}) {
        Scene scene;
        scene.materials = {shines ? unlit_material() : matte(0)};
        scene.materials[0].double_sided = true;
        add(scene, rectangle({-99.9f, -0.6f, 100}, {100, 0, 0}, {0, 0, -200}));
        VolumeView view = fog(2, 0.8f, shines ? 0.0f : 1.0f);
        view.max_bounces = 1;
        const double expected =
            scattered_once(density, albedo, [&](const glm::dvec3& p, const glm::dvec3& w) {
                return blocked(p, w) == shines ? 1.0 : 0.0;
            });
        SurfaceVolumeParams p = params(16, VolumeMode::path);
        p.medium.samples_per_step = 32;
        const Estimate found = mean_of(render(scene, view, through_the_middle(), p, 4));
        EXPECT_LT(found.error, 0.02 * expected);
        EXPECT_LT(z_of(found, expected), z_limit(3)) << found.mean << ' ' << expected;
    }
}

TEST_F(MeshTransportTest, AWallInTheSunLightsTheMediumInTheShade) {
    // The sun shines along +x on a white wall at x = 2; a plate keeps it off the cube and off the
    // part of the wall behind.
    Scene scene;
    scene.materials = {matte(1), matte(0)};
    add(scene, rectangle({2, -4, -4}, {0, 8, 0}, {0, 0, 8}, 0));
    add(scene, rectangle({-1, -1, -1}, {0, 2, 0}, {0, 0, 2}, 1));
    scene.lights = {{.name = "sun",
        .type = LightType::directional,
        .direction = {1, 0, 0},
        .intensity = glm::vec3(static_cast<float>(kPi)),
        .casts_shadow = true}};
    VolumeView view = lit_by(scene, fog(2, 0.8f, 0), glm::vec3(0.0f));
    view.max_bounces = 2;
    const double expected = scattered_once(2, 0.8, [&](const glm::dvec3& p, const glm::dvec3& w) {
        const glm::dvec3 at = p + w * ((2 - p.x) / w.x);
        const double aside = std::max(std::abs(at.y), std::abs(at.z));
        return w.x > 0 && aside > 1 && aside < 4 ? 1.0 : 0.0;
    });
    SurfaceVolumeParams p = params(16, VolumeMode::noncaching);
    p.medium.samples_per_step = 32;
    const Estimate found = mean_of(render(scene, view, through_the_middle(), p, 6));
    EXPECT_LT(found.error, 0.02 * expected);
    EXPECT_LT(z_of(found, expected), z_limit(3)) << found.mean << ' ' << expected;
}

TEST_F(MeshTransportTest, AFarMeshChangesNoneOfTheSunsManyScatterings) {
    // Shadow rays of all scatterings, also of those behind a search that has found nothing.
    Scene scene;
    scene.materials = {matte(0)};
    scene.lights = {{.name = "sun",
        .type = LightType::directional,
        .direction = {0, 0, -1},
        .intensity = glm::vec3(static_cast<float>(kPi)),
        .casts_shadow = true}};
    VolumeView view = lit_by(scene, fog(20, 0.9f, 0), glm::vec3(0.0f));
    SurfaceVolumeParams p = params(16, VolumeMode::path);
    p.medium.samples_per_step = 32;
    const Estimate alone = mean_of(render(scene, view, through_the_middle(), p, 4));
    add(scene, rectangle({9, 9, -9}, {0.01f, 0, 0}, {0, 0.01f, 0}));
    view.seed += 1;
    const Estimate beside = mean_of(render(scene, view, through_the_middle(), p, 4));
    EXPECT_LT(std::max(alone.error, beside.error), 0.02 * alone.mean);
    const Estimate difference{beside.mean - alone.mean, std::hypot(alone.error, beside.error)};
    EXPECT_LT(z_of(difference, 0), z_limit(1)) << beside.mean << ' ' << alone.mean;
}

TEST_F(MeshTransportTest, LampsLightTheMediumExceptBehindMeshes) {
    // A lamp above the cube, a plate between it and the far side; the second time a spot light, and
    // the sun from above.
    const glm::dvec3 at(0.1, 1.5, 0.2);
    const double edge = 0.1, intensity = 9, irradiance = kPi, inner = 0.1, outer = 1.2;
    for (const LightType type : {LightType::point, LightType::spot}) {
        const bool spot = type == LightType::spot;
        Scene scene;
        scene.materials = {matte(0), matte(0)};
        scene.materials[1].emissive = glm::vec3(1e-6f); // the lamp's glass, which does not stop it
        add(scene, rectangle({-4, 1, static_cast<float>(edge)}, {8, 0, 0}, {0, 0, -4}));
        add(scene, rectangle({0.085f, 1.4f, 0.1f}, {0.015f, 0, 0}, {0, 0, 0.15f}, 1));
        scene.lights = {{.name = "lamp",
            .type = type,
            .position = at,
            .direction = {0, -1, 0},
            .intensity = glm::vec3(static_cast<float>(intensity)),
            .inner_cone = static_cast<float>(inner),
            .outer_cone = static_cast<float>(outer)}};
        if (spot) {
            scene.lights.push_back({.name = "sun",
                .type = LightType::directional,
                .direction = {0, -1, 0},
                .intensity = glm::vec3(static_cast<float>(irradiance)),
                .casts_shadow = true});
        }
        VolumeView view = lit_by(scene, fog(2, 0.8f, 0), glm::vec3(0.0f));
        view.max_bounces = 1;
        double expected = 0;
        constexpr int kSteps = 20000;
        for (int i = 0; i < kSteps; ++i) {
            const double depth = (i + 0.5) / kSteps;
            const glm::dvec3 p(0, 0, 0.5 - depth), way = at - p;
            const double length = glm::length(way), scale = 1 / (std::cos(inner) - std::cos(outer));
            const double cone =
                spot ? std::clamp((way.y / length - std::cos(outer)) * scale, 0.0, 1.0) : 1.0;
            const bool lit = p.z + way.z / way.y > edge, sunny = spot && p.z > edge;
            const double inside = 0.5 * length / way.y; // it leaves by the upper side
            const double lamp = intensity * cone * cone * std::exp(-2 * inside) / (length * length);
            expected += 2 * std::exp(-2 * depth) * 0.8 / (4 * kPi) *
                        ((lit ? lamp : 0) + (sunny ? irradiance * std::exp(-1.0) : 0)) / kSteps;
        }
        SurfaceVolumeParams p = params(16, VolumeMode::path);
        p.medium.samples_per_step = 32;
        const Estimate found = mean_of(render(scene, view, through_the_middle(), p, 4));
        EXPECT_LT(found.error, 0.02 * expected);
        EXPECT_LT(z_of(found, expected), z_limit(2)) << found.mean << ' ' << expected;
        // The cache is lit alike, but for what its cells blend where the shadow begins.
        p.medium.mode = VolumeMode::caching;
        p.medium.gather = false;
        p.medium.samples_per_step = 1;
        p.medium.cache_scale = 1;
        p.medium.cache_error = 0.005f;
        const Estimate cached = mean_of(render(scene, view, through_the_middle(), p, 60));
        EXPECT_NEAR(cached.mean, expected, 0.03 * expected);
    }
}

/// Six walls around the cube; without the last, a room with an open side.
Scene room(float albedo, bool closed = true) {
    Scene scene;
    scene.materials = {matte(albedo)};
    for (int side = 0; side < (closed ? 6 : 5); ++side) {
        const int axis = side / 2;
        glm::vec3 corner(-1.0f), across(0.0f), up(0.0f);
        corner[axis] = side % 2 == 0 ? -1.0f : 1.0f;
        across[(axis + 1) % 3] = 2;
        up[(axis + 2) % 3] = 2;
        add(scene, rectangle(corner, across, up));
    }
    scene.background = glm::vec3(1.0f);
    return scene;
}

TEST_F(MeshTransportTest, FogInAClosedRoomIsBlackWhateverIsOutside) {
    const Camera camera = look_at({0.1f, 0.2f, 0.9f}, {0, 0, 0}, 70);
    for (const VolumeMode mode : {VolumeMode::path, VolumeMode::noncaching, VolumeMode::caching}) {
        for (const bool gather : {true, false}) {
            if (gather && mode != VolumeMode::caching) continue;
            SurfaceVolumeParams p = params(16, mode);
            p.medium.gather = gather;
            // White fog between white walls: paths that could go on for ever.
            const bool white = mode == VolumeMode::path;
            const VolumeView view = fog(4, white ? 1.0f : 0.9f, 1);
            const float walls = white ? 1.0f : 0.5f;
            const Image dark = render(room(walls), view, camera, p, 2);
            for (const float value : dark.plane(0)) ASSERT_EQ(value, 0.0f) << name_of(mode);
            const Image open = render(room(0.5f, false), view, camera, p, 2);
            EXPECT_GT(mean_of(open).mean, 0.02) << name_of(mode);
        }
    }
}

TEST_F(MeshTransportTest, TheBudgetOfIterationsChangesNothing) {
    // Meshes in the medium, some with holes; isosurfaces.
    const LitScene lit(device(), varied_scene(true));
    const Camera camera = lit.scene().cameras.front();
    Volume volume = cube();
    for (std::size_t i = 0; i < volume.voxels.size(); ++i)
        volume.voxels[i] = std::byte(i * 37 % 256);
    VolumeView view = fog(6, 0.9f, 1);
    view.surfaces = {{.value = 240, .opacity = 0.5f}};
    view = lit_by(lit.scene(), view, lit.scene().ambient);
    const Image none;
    const MediumSource medium{volume, rising(), none, view, {{2, 2, 0}, {10, 20, 30}, 6}};
    std::vector<Image> pictures;
    for (const std::uint32_t iterations : {kPathIterations, 400u}) {
        SurfaceVolumeParams p = params(12, VolumeMode::path);
        p.medium.iterations = iterations;
        SurfaceVolume picture(device(), &lit, medium, camera, p);
        for (int i = 0; i < 2; ++i) picture.execute();
        picture.finish();
        EXPECT_EQ(picture.medium()->statistics().truncated, 0u);
        pictures.push_back(picture.picture());
    }
    for (int c = 0; c < 4; ++c)
        EXPECT_TRUE(std::ranges::equal(pictures[0].plane(c), pictures[1].plane(c)));
}

TEST_F(MeshTransportTest, ATreeIsThereOnlyForWhatIsScattered) {
    const LitScene lit(device(), room(0.5f));
    const Volume volume = cube();
    const Image none;
    VolumeView view = fog(4, 0, 1);
    const Camera camera = through_the_middle();
    SurfaceVolume picture(device(), &lit, MediumSource{volume, rising(), none, view, {}}, camera,
        params(8, VolumeMode::path));
    const auto explanation = [&] {
        return explain(picture.executor().graph().declaration(), picture.executor().plan());
    };
    EXPECT_FALSE(picture.executor().graph().find_buffer("mesh_tree"));
    EXPECT_NE(
        explanation().find("'mesh_tree': omitted: the medium scatters nothing"), std::string::npos);
    // A medium that begins to scatter gets it, and one that stops loses it.
    view.albedo = 0.5f;
    picture.medium()->set_view(view);
    EXPECT_TRUE(picture.executor().graph().find_buffer("mesh_tree"));
    EXPECT_EQ(explanation().find("'mesh_tree': omitted"), std::string::npos);
    view.max_bounces = 0;
    picture.medium()->set_view(view);
    EXPECT_FALSE(picture.executor().graph().find_buffer("mesh_tree"));
}

} // namespace
} // namespace ockham::test

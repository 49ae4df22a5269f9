// SPDX-License-Identifier: Apache-2.0
// Meshes and a medium in one picture: equal to each technique alone where the other has nothing to
// show, nothing in the plan that is not needed, closed forms and furnaces where both are there.
#include "framework/graph/explain/explain.hpp"
#include "passes/pipelines/surface_volume.hpp"
#include "passes/volume/frame.hpp"
#include "tests/support/equal_pictures.hpp"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/surface_scenes.hpp"
#include "tests/support/z_test.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ockham::test {
namespace {

/// 8 x 8 x 8 voxels of these values, 0 to 255.
template <class Value>
Volume volume_of(glm::uvec3 dims, Value value) {
    Volume volume;
    volume.name = "test";
    volume.dims = dims;
    for (std::uint32_t z = 0; z < dims.z; ++z)
        for (std::uint32_t y = 0; y < dims.y; ++y)
            for (std::uint32_t x = 0; x < dims.x; ++x)
                volume.voxels.push_back(std::byte(value(glm::uvec3(x, y, z))));
    return volume;
}
Volume full(glm::uvec3 dims = glm::uvec3(8)) {
    return volume_of(dims, [](glm::uvec3) { return 255; });
}
/// Empty in one half, uneven in the other.
Volume uneven() {
    return volume_of(glm::uvec3(24, 20, 16),
        [](glm::uvec3 v) { return v.x < 10 ? 0u : (v.x * 37u + v.y * 91u + v.z * 53u) % 256u; });
}
/// Waves that a step of half a voxel follows.
Volume smooth() {
    return volume_of(glm::uvec3(24, 20, 16), [](glm::uvec3 v) {
        const double wave = std::sin(0.4 * v.x) * std::cos(0.3 * v.y + 0.35 * v.z);
        return std::lround(127.5 * (1 + wave));
    });
}
TransferFunction rising(double opacity = 1) {
    return {{{.value = 0, .opacity = 0}, {.value = 255, .opacity = opacity}}};
}

/// Dark, absorbing.
VolumeView absorbing(float density) {
    VolumeView view;
    view.environment = glm::vec3(0.0f);
    view.density_scale = density;
    view.albedo = 0;
    return view;
}

Camera along_z(float height) {
    Camera camera = look_at({0, 0, 5}, {0, 0, 0}, 30);
    camera.orthographic_height = height;
    return camera;
}

SurfaceVolumeParams params(std::uint32_t width, std::uint32_t height,
    VolumeMode mode = VolumeMode::path, AaMethod method = AaMethod::adaptive) {
    SurfaceVolumeParams p;
    p.surfaces.method = method;
    p.surfaces.metric = MetricKind::ockham;
    p.surfaces.resolve = Resolve::stratified;
    p.surfaces.order_kind = SampleOrder::optimal;
    p.surfaces.width = p.medium.width = width;
    p.surfaces.height = p.medium.height = height;
    p.surfaces.export_counts = true;
    p.medium.mode = mode;
    p.medium.gather = false;
    p.medium.sobol = false;
    return p;
}

bool runs(SurfaceVolume& picture, std::string_view pass) {
    const Declaration& declaration = picture.executor().graph().declaration();
    return std::ranges::any_of(
        declaration.passes, [&](const PassDecl& p) { return p.name.starts_with(pass); });
}

class SurfaceVolumeTest : public GpuTest {
protected:
    static Image after(SurfaceVolume& picture, int steps) {
        for (int i = 0; i < steps; ++i) picture.execute();
        picture.finish();
        return picture.picture();
    }
    static Image render(const Scene& scene, const Volume& volume, const VolumeView& view,
        const Camera& camera, const SurfaceVolumeParams& p, int steps,
        const VolumePlacement& place = {}) {
        const LitScene lit(device(), scene);
        const Image none;
        SurfaceVolume picture(
            device(), &lit, MediumSource{volume, rising(), none, view, place}, camera, p);
        return after(picture, steps);
    }
};

TEST_F(SurfaceVolumeTest, WithoutAMediumItIsAdaptiveAaBitForBit) {
    const LitScene lit(device(), varied_scene(true));
    const Camera camera = lit.scene().cameras.front();
    const SurfaceVolumeParams p = params(48, 36);
    AdaptiveAa alone(device(), lit, camera, p.surfaces);
    alone.execute();
    const Image none;
    const Volume field = uneven();
    VolumeView thin = absorbing(0);
    const MediumSource sources[] = {{field, rising(0), none, absorbing(10), {}},
        {field, rising(), none, thin, {}}}; // no opacity, no density
    for (int i = 0; i < 3; ++i) {
        SurfaceVolume picture(device(), &lit,
            i < 2 ? std::optional<MediumSource>(sources[i]) : std::nullopt, camera, p);
        EXPECT_TRUE(equal(after(picture, 2), alone.picture())) << i;
        EXPECT_EQ(picture.sample_percent(), alone.sample_counts().percent);
        // Nothing of the medium exists, and the plan says why.
        EXPECT_EQ(picture.medium(), nullptr);
        EXPECT_EQ(picture.executor().plan().bytes_peak, alone.executor().plan().bytes_peak);
        EXPECT_EQ(picture.executor().pipeline_count(), alone.executor().pipeline_count());
        const Declaration& declaration = picture.executor().graph().declaration();
        EXPECT_NE(explain(declaration, picture.executor().plan())
                      .find(i < 2 ? "pass 'path_trace': omitted: the volume is transparent"
                                  : "pass 'path_trace': omitted: no volume"),
            std::string::npos);
    }
}

TEST_F(SurfaceVolumeTest, WithoutMeshesItIsVolumeGiBitForBit) {
    const LitScene sky(device(), Scene{});
    const Volume field = uneven();
    const Image none;
    VolumeView view = absorbing(10);
    view.albedo = 0.9f;
    view.environment = {0.2f, 0.3f, 0.4f};
    view.light_irradiance = glm::vec3(2.0f);
    view.surfaces = {{.value = 200, .opacity = 0.5f}};
    for (const VolumeMode mode : {VolumeMode::path, VolumeMode::caching}) {
        const SurfaceVolumeParams p = params(32, 24, mode);
        VolumeGi alone(device(), field, rising(), none, view, volume_camera(), p.medium);
        for (int i = 0; i < 3; ++i) alone.execute();
        alone.finish();
        for (const LitScene* lit : {static_cast<const LitScene*>(nullptr), &sky}) {
            SurfaceVolume picture(
                device(), lit, MediumSource{field, rising(), none, view, {}}, volume_camera(), p);
            EXPECT_TRUE(equal(after(picture, 3), alone.picture())) << name_of(mode);
            EXPECT_EQ(picture.surfaces(), nullptr);
            EXPECT_FALSE(runs(picture, "gbuffer") || runs(picture, "mesh") ||
                         runs(picture, "over_meshes") || runs(picture, "shade"));
            EXPECT_EQ(picture.executor().plan().bytes_peak, alone.executor().plan().bytes_peak);
            EXPECT_EQ(picture.executor().pipeline_count(), alone.executor().pipeline_count());
        }
    }
}

TEST_F(SurfaceVolumeTest, AMeshBehindOrInsideASlabIsDimmedExactly) {
    for (const float z : {-1.0f, 0.0f, 0.25f, 1.0f}) {
        Scene scene;
        scene.background = glm::vec3(7.0f); // not seen
        scene.materials = {unlit_material({1.0f, 0.5f, 0.25f})};
        add(scene, rectangle({-2, -2, z}, {4, 0, 0}, {0, 4, 0}));
        const Image picture = render(
            scene, full(), absorbing(2), along_z(0.5f), params(8, 8, VolumeMode::caching), 16);
        const double t = std::exp(-2.0 * std::clamp(0.5 - z, 0.0, 1.0));
        for (std::size_t i = 0; i < picture.pixels(); ++i) {
            EXPECT_NEAR(picture.plane(0)[i], t, 4e-6) << z;
            EXPECT_NEAR(picture.plane(2)[i], 0.25 * t, 1e-6) << z;
            EXPECT_NEAR(picture.plane(3)[i], 1.0, 1e-6) << z;
        }
    }
}

TEST_F(SurfaceVolumeTest, TheBackgroundIsDimmedToo) {
    Scene scene; // a mesh far off to the side: there are meshes, but none is seen
    scene.background = glm::vec3(3.0f);
    scene.materials = {unlit_material()};
    add(scene, rectangle({20, 0, 0}, {1, 0, 0}, {0, 1, 0}));
    SurfaceVolumeParams p = params(8, 8, VolumeMode::caching);
    const Image picture = render(scene, full(), absorbing(2), along_z(0.5f), p, 16);
    for (const float value : picture.plane(1)) EXPECT_NEAR(value, 3.0 * std::exp(-2.0), 1e-5);
    for (const float value : picture.plane(3)) EXPECT_NEAR(value, 1 - std::exp(-2.0), 4e-6);
    // Traced: a share of the paths is absorbed.
    p.medium.mode = VolumeMode::path;
    const Image traced = render(scene, full(), absorbing(2), along_z(0.5f), p, 64);
    double sum = 0;
    for (const float value : traced.plane(1)) sum += value / 3.0;
    const double n = 64 * 64, t = std::exp(-2.0);
    EXPECT_LT(z_of({sum / 64, std::sqrt(t * (1 - t) / n)}, t), z_limit(1));
}

TEST_F(SurfaceVolumeTest, WhereTheMediumIsNotInTheWayMeshesKeepTheirBits) {
    const LitScene lit(device(), varied_scene());
    const Camera camera = lit.scene().cameras.front();
    const Bounds bounds = lit.gpu().bounds();
    const Volume field = full();
    const Image none;
    VolumeView view = absorbing(50);
    view = lit_by(lit.scene(), view, glm::vec3(0.0f));
    // Behind everything, in the left half of the picture.
    const glm::vec3 right = glm::cross(camera.forward, camera.up);
    const glm::vec3 far =
        bounds.center() + bounds.radius() * (4.0f * camera.forward - 2.0f * right);
    const SurfaceVolumeParams p = params(48, 36);
    SurfaceVolume picture(device(), &lit,
        MediumSource{field, rising(), none, view, {far, {0, 0, 0}, bounds.radius()}}, camera, p);
    AdaptiveAa alone(device(), lit, camera, p.surfaces);
    alone.execute();
    const Image with = after(picture, 4), without = alone.picture();
    std::size_t changed = 0, left = 0;
    for (int y = 0; y < 36; ++y)
        for (int x = 0; x < 48; ++x) {
            const auto i = static_cast<std::size_t>(48 * y + x);
            const bool same = with.plane(1)[i] == without.plane(1)[i];
            changed += same ? 0u : 1u;
            left += same || x < 24 ? 1u : 0u;
        }
    EXPECT_GT(changed, 0u);
    EXPECT_EQ(left, with.pixels());
    EXPECT_EQ(picture.sample_percent(), alone.sample_counts().percent);
}

/// A white floor at y = -1, lit from above the slab that hangs over it; camera below the slab.
Scene floor_scene(const Light& light) {
    Scene scene;
    Material white;
    white.metallic = 0;
    scene.materials = {white};
    add(scene, rectangle({-8, -1, 8}, {16, 0, 0}, {0, 0, -16}));
    scene.lights = {light};
    return scene;
}

TEST_F(SurfaceVolumeTest, ASlabShadowsAFloorExactly) {
    // The slab: 4 x 0.5 x 4, its middle at the origin.
    const Volume slab = full({16, 16, 2});
    const VolumePlacement place{{0, 0, 0}, {0, 0, 0}, 4};
    Camera camera = look_at({0, -0.5f, 0.6f}, {0, -1, 0}, 20);
    Light sun{.name = "sun",
        .type = LightType::directional,
        .direction = glm::normalize(glm::vec3(0.3f, -1.0f, 0.2f)),
        .intensity = glm::vec3(3.0f)};
    Light lamp{.name = "lamp",
        .type = LightType::point,
        .position = {0.2f, 2.0f, 0.1f},
        .intensity = glm::vec3(9)};
    const SurfaceVolumeParams p = params(6, 6, VolumeMode::path, AaMethod::none);
    const auto slant = [&](const Light& light, glm::dvec3 at) {
        const glm::dvec3 to = light.type == LightType::point ? glm::dvec3(light.position) - at
                                                             : -glm::dvec3(light.direction);
        return glm::length(to) / to.y;
    };
    for (const Light& light : {sun, lamp}) {
        const Image lit = render(floor_scene(light), slab, absorbing(0), camera, p, 1, place);
        const Image dim = render(floor_scene(light), slab, absorbing(1.5f), camera, p, 1, place);
        for (int y = 0; y < 6; ++y)
            for (int x = 0; x < 6; ++x) {
                // Where the pixel's ray meets the floor.
                const double h = std::tan(glm::radians(10.0));
                const glm::dvec3 right =
                    glm::cross(glm::dvec3(camera.forward), glm::dvec3(camera.up));
                const glm::dvec3 way = glm::dvec3(camera.forward) +
                                       h * ((x + 0.5) / 3.0 - 1.0) * right +
                                       h * (1.0 - (y + 0.5) / 3.0) * glm::dvec3(camera.up);
                const glm::dvec3 at =
                    glm::dvec3(camera.position) + way * ((-1.0 - camera.position.y) / way.y);
                const std::size_t i = static_cast<std::size_t>(6 * y + x);
                ASSERT_GT(lit.plane(0)[i], 0.01f);
                EXPECT_NEAR(dim.plane(0)[i] / lit.plane(0)[i],
                    std::exp(-1.5 * 0.5 * slant(light, at)), 1e-5)
                    << x << ' ' << y;
            }
    }
}

TEST_F(SurfaceVolumeTest, OpaqueFogHidesBrightEdgesAtAnyNumberOfSteps) {
    // Glowing fog, so dense that nothing behind it is seen, before the edge of a very bright card.
    TransferFunction glowing = rising();
    for (TransferPoint& point : glowing.points) point.emission = glm::dvec3(0.5);
    Scene scene;
    scene.materials = {unlit_material(glm::vec3(100.0f))};
    add(scene, rectangle({0.013f, -2, -1}, {4, 0.3f, 0}, {0, 4, 0}));
    const LitScene lit(device(), scene);
    const Volume field = full();
    const Image none;
    for (const VolumeMode mode : {VolumeMode::path, VolumeMode::caching}) {
        SurfaceVolume picture(device(), &lit, MediumSource{field, glowing, none, absorbing(60), {}},
            along_z(0.5f), params(12, 12, mode));
        for (int step = 1; step <= 5; ++step) {
            const Image image = after(picture, 1);
            for (const float value : image.plane(0))
                ASSERT_NEAR(value, 0.5, 1e-3) << name_of(mode) << ", step " << step;
        }
    }
}

/// White cards at odd angles, some of them outside of the medium, in white light from everywhere.
Scene furnace() {
    Scene scene;
    Material white;
    white.metallic = 0;
    white.ior = 1; // no reflection besides Lambert's
    white.double_sided = true;
    scene.materials = {white};
    add(scene, rectangle({-0.3f, -0.4f, -0.1f}, {0.5f, 0.1f, 0.3f}, {-0.1f, 0.6f, 0.1f}));
    add(scene, rectangle({0.05f, -0.2f, 0.2f}, {0.3f, 0.2f, -0.1f}, {-0.1f, 0.3f, 0.3f}));
    add(scene, rectangle({-0.7f, 0.1f, 0.9f}, {0.9f, 0.05f, 0}, {0, 0.2f, 0.1f}));
    scene.background = scene.ambient = glm::vec3(1.0f);
    return scene;
}

TEST_F(SurfaceVolumeTest, AWhiteFurnaceStaysWhite) {
    VolumeView view = absorbing(8);
    view.albedo = 1;
    view.environment = glm::vec3(1.0f);
    const Camera camera = look_at({0.4f, 0.3f, 2.2f}, {0, 0, 0}, 32);
    // Composed: light and what it hides are weighed alike.
    SurfaceVolumeParams p = params(40, 30, VolumeMode::caching);
    const Image composed = render(furnace(), smooth(), view, camera, p, 48);
    for (int c = 0; c < 3; ++c)
        for (const float value : composed.plane(c)) ASSERT_NEAR(value, 1.0, 1e-3); // half floats
    // Traced: what a path brings is what it hides, so that there is no noise either.
    for (const VolumeMode mode : {VolumeMode::path, VolumeMode::noncaching}) {
        p.medium.mode = mode;
        const Image traced = render(furnace(), uneven(), view, camera, p, 4);
        for (int c = 0; c < 3; ++c)
            for (const float value : traced.plane(c)) ASSERT_NEAR(value, 1.0, 1e-5);
    }
}

TEST_F(SurfaceVolumeTest, AnIsothermalFurnaceIsAsBrightEverywhere) {
    // The medium absorbs half and glows as brightly as all else.
    const Volume field = uneven();
    TransferFunction glowing = rising();
    for (TransferPoint& point : glowing.points) point.emission = glm::dvec3(1.0);
    VolumeView view = absorbing(8);
    view.albedo = 0.5f;
    view.environment = glm::vec3(1.0f);
    const LitScene lit(device(), furnace());
    const Image none;
    SurfaceVolume picture(device(), &lit, MediumSource{field, glowing, none, view, {}},
        look_at({0.4f, 0.3f, 2.2f}, {0, 0, 0}, 32), params(40, 30));
    const Image traced = after(picture, 16);
    double sum = 0, square = 0;
    for (const float value : traced.plane(1)) sum += value - 1, square += (value - 1) * (value - 1);
    const auto n = static_cast<double>(traced.pixels());
    const double error = std::sqrt(square / n / n);
    EXPECT_GT(error, 1e-4) << "nothing scatters";
    EXPECT_LT(z_of({sum / n, error}, 0.0), z_limit(1));
}

TEST_F(SurfaceVolumeTest, MeshesKeepTheSunOutOfTheMedium) {
    // A plate above the left half of the box; single scattering, seen along z.
    Scene scene;
    Material white;
    white.double_sided = true;
    scene.materials = {white};
    add(scene, rectangle({-2, 1, 2}, {2, 0, 0}, {0, 0, -4}));
    scene.lights = {{.name = "sun",
        .type = LightType::directional,
        .direction = {0, -1, 0},
        .intensity = glm::vec3(std::numbers::pi_v<float>),
        .casts_shadow = true}};
    VolumeView view = absorbing(2);
    view.albedo = 0.8f;
    view.max_bounces = 1;
    view = lit_by(scene, view, glm::vec3(0.0f));
    SurfaceVolumeParams p = params(16, 16, VolumeMode::noncaching, AaMethod::none);
    // w E / 4 pi * mean of exp(-sigma depth) * (1 - exp(-sigma))
    const double expected = 0.8 / 4 * (1 - std::exp(-2.0)) / 2 * (1 - std::exp(-2.0));
    p.medium.samples_per_step = 16;
    const Image picture = render(scene, full(), view, along_z(1), p, 16);
    double sum = 0, square = 0;
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 16; ++x) {
            const double value = picture.plane(0)[static_cast<std::size_t>(16 * y + x)];
            if (x < 7) {
                EXPECT_EQ(value, 0.0) << x << ' ' << y;
            }
            if (x > 8) sum += value, square += value * value;
        }
    const double n = 7 * 16, mean = sum / n;
    // Values of rows differ, so this error is too large, if anything; noise is a third of it.
    EXPECT_LT(z_of({mean, 0.3 * std::sqrt((square / n - mean * mean) / n)}, expected), z_limit(1));
    // The cache sees the same shadow.
    p.medium.mode = VolumeMode::caching;
    p.medium.samples_per_step = 1;
    const Image cached = render(scene, full(), view, along_z(1), p, 16);
    for (int y = 0; y < 16; ++y) {
        EXPECT_LT(cached.plane(0)[static_cast<std::size_t>(16 * y + 4)], 1e-6f);
        EXPECT_GT(cached.plane(0)[static_cast<std::size_t>(16 * y + 12)], 0.02f);
    }
}

TEST_F(SurfaceVolumeTest, IsosurfacesHideMeshesBehindThemAndNoOthers) {
    const Volume ball = volume_of(glm::uvec3(24), [](glm::uvec3 v) {
        const double r = glm::length(glm::dvec3(v) - 11.5) / 12;
        return std::lround(255 * std::clamp(1 - r, 0.0, 1.0));
    });
    VolumeView view = absorbing(0);
    view.surfaces = {{.value = 127.5}}; // radius 1/4
    view.environment = glm::vec3(0.5f);
    Scene scene;
    scene.materials = {unlit_material(glm::vec3(4.0f)), unlit_material(glm::vec3(2.0f))};
    add(scene, rectangle({-2, -2, -1}, {4, 0, 0}, {0, 4, 0}, 0));      // behind
    add(scene, rectangle({-2, -0.1f, 1}, {4, 0, 0}, {0, 0.2f, 0}, 1)); // a bar before it
    const Image picture =
        render(scene, ball, view, along_z(1), params(20, 20, VolumeMode::noncaching), 16);
    const auto at = [&](int x, int y) {
        return picture.plane(0)[static_cast<std::size_t>(20 * y + x)];
    };
    EXPECT_FLOAT_EQ(at(10, 10), 2.0f);
    EXPECT_FLOAT_EQ(at(1, 1), 4.0f);
    EXPECT_NEAR(at(10, 6), 0.8f * 0.5f, 1e-5f); // Lambert in the environment's light
    // Its silhouette is smooth: no pixel of the row across it is brighter than the card.
    bool between = false;
    for (int x = 0; x < 20; ++x) {
        EXPECT_GE(at(x, 7), 0.399f);
        EXPECT_LE(at(x, 7), 4.001f);
        between = between || (at(x, 7) > 0.5f && at(x, 7) < 3.9f);
    }
    EXPECT_TRUE(between);
}

TEST_F(SurfaceVolumeTest, AMovedCameraEqualsAFreshPicture) {
    const LitScene lit(device(), varied_scene(true));
    const Volume field = uneven();
    const Image none;
    VolumeView view = absorbing(6);
    view.albedo = 0.9f;
    view = lit_by(lit.scene(), view, lit.scene().ambient);
    Camera first = lit.scene().cameras.front(), second = first;
    second.position += glm::vec3(0.3f, 0.1f, 0.0f);
    const VolumePlacement place{{2, 2, 0}, {10, 20, 30}, 6};
    const MediumSource medium{field, rising(), none, view, place};
    const SurfaceVolumeParams p = params(24, 18);
    SurfaceVolume moved(device(), &lit, medium, first, p), fresh(device(), &lit, medium, second, p);
    after(moved, 2);
    moved.set_camera(second);
    EXPECT_TRUE(equal(after(moved, 3), after(fresh, 3)));
    EXPECT_EQ(moved.sample_percent(), fresh.sample_percent());
}

TEST_F(SurfaceVolumeTest, APartIsThatPartOfThePicture) {
    const LitScene lit(device(), varied_scene(true));
    const Volume field = smooth();
    const Image none;
    const TransferFunction even{{{.value = 0, .opacity = 1}, {.value = 255, .opacity = 1}}};
    VolumeView view = absorbing(0.2f);
    view.surfaces = {{.value = 160, .opacity = 1}};
    view = lit_by(lit.scene(), view, glm::vec3(0.0f));
    const MediumSource medium{field, even, none, view, {{2, 2, 0}, {10, 20, 30}, 6}};
    Camera camera = lit.scene().cameras.front();
    for (const float height : {0.0f, 6.0f}) {
        camera.orthographic_height = height;
        SurfaceVolumeParams p = params(24, 18, VolumeMode::caching, AaMethod::ssaa);
        p.surfaces.m = 1;
        SurfaceVolume whole(device(), &lit, medium, camera, p);
        const Image wanted = after(whole, 2);
        p.medium.width = 7, p.medium.height = 5;
        p.medium.part_of = {24, 18};
        SurfaceVolume part(device(), &lit, medium, camera, p);
        // Even ones: gradients of textures are those of 2 x 2 fragments.
        for (const glm::ivec2 origin : {glm::ivec2(0), glm::ivec2(6, 8), glm::ivec2(16, 12)}) {
            part.set_origin(origin);
            const Image seen = after(part, 2);
            for (int y = 0; y < 5; ++y)
                for (int x = 0; x < 7; ++x)
                    for (int c = 0; c < 4; ++c)
                        EXPECT_NEAR(
                            seen.at(x, y, c), wanted.at(origin.x + x, origin.y + y, c), 2e-5)
                            << origin.x + x << " " << origin.y + y << " " << c;
        }
    }
}

TEST_F(SurfaceVolumeTest, RefusesWhatCannotBeSeenThroughAMedium) {
    const LitScene lit(device(), furnace());
    const Volume field = full();
    const Image none;
    const MediumSource medium{field, rising(), none, absorbing(1), {}};
    const auto refusal = [&](auto change) {
        SurfaceVolumeParams p = params(8, 8);
        change(p);
        return error_of([&] { SurfaceVolume(device(), &lit, medium, along_z(1), p); });
    };
    EXPECT_NE(refusal([](auto& p) { p.surfaces.method = AaMethod::fxaa; }).find("--method"),
        std::string::npos);
    EXPECT_NE(refusal([](auto& p) { p.surfaces.resolve = Resolve::prefix; }).find("--resolve"),
        std::string::npos);
    EXPECT_NE(refusal([](auto& p) { p.surfaces.dispatch = Dispatch::repack; }).find("--dispatch"),
        std::string::npos);
    EXPECT_NE(
        refusal([](auto& p) { p.surfaces.gbuffer = GbufferLayout::visibility; }).find("--gbuffer"),
        std::string::npos);
}

TEST(VolumePlacementTest, IsUprightThenTurnedThenMoved) {
    Volume volume = full({2, 4, 8});
    const VolumePlace own = place_of(volume);
    const auto centre = [](const VolumePlace& p) { return p.corner + p.edges * glm::dvec3(0.5); };
    const VolumePlace upright = placed(own, {});
    EXPECT_NEAR(glm::length(centre(upright)), 0.0, 1e-12);
    EXPECT_NEAR(glm::length(upright.edges[2] - glm::dvec3(0, 1, 0)), 0.0, 1e-12);
    EXPECT_NEAR(glm::length(upright.edges[1] - glm::dvec3(0, 0, -0.5)), 0.0, 1e-12);
    const VolumePlace turned = placed(own, {{1, 2, 3}, {0, 0, 90}, 2});
    EXPECT_NEAR(glm::length(centre(turned) - glm::dvec3(1, 2, 3)), 0.0, 1e-12);
    EXPECT_NEAR(glm::length(turned.edges[2] - glm::dvec3(-2, 0, 0)), 0.0, 1e-12);
    EXPECT_NEAR(glm::determinant(turned.edges), 8 * glm::determinant(own.edges), 1e-12);
}

} // namespace
} // namespace ockham::test

// SPDX-License-Identifier: Apache-2.0
// Isosurfaces among meshes are samples of the G-buffer: as bright as closed forms say and as they
// are without meshes, antialiased by counts in one step, and nothing in the plan where none is
// opaque.
#include "framework/graph/explain/explain.hpp"
#include "framework/image_error/image_error.hpp"
#include "passes/pipelines/surface_volume.hpp"
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

constexpr double kPi = std::numbers::pi;

template <class Value>
Volume volume_of(std::uint32_t side, Value value) {
    Volume volume;
    volume.name = "test";
    volume.dims = glm::uvec3(side);
    for (std::uint32_t z = 0; z < side; ++z)
        for (std::uint32_t y = 0; y < side; ++y)
            for (std::uint32_t x = 0; x < side; ++x)
                volume.voxels.push_back(std::byte(value(glm::uvec3(x, y, z))));
    return volume;
}
/// Rises along its y, which is the world's -z once it stands upright: value 127.5 at z = 0.
Volume ramp() {
    return volume_of(16, [](glm::uvec3 v) { return 17 * v.y; });
}
/// Value 127.5 at radius 1/4 about the origin.
Volume ball() {
    return volume_of(24, [](glm::uvec3 v) {
        const double r = glm::length(glm::dvec3(v) - 11.5) / 12;
        return std::lround(255 * std::clamp(1 - r, 0.0, 1.0));
    });
}
TransferFunction everywhere() {
    return {{{.value = 0, .opacity = 1}, {.value = 255, .opacity = 1}}};
}

VolumeView absorbing(float density) {
    VolumeView view;
    view.environment = glm::vec3(0.0f);
    view.density_scale = density;
    view.albedo = 0;
    return view;
}

/// A mesh that nobody sees, for there must be one.
Scene hardly_any() {
    Scene scene;
    scene.materials = {unlit_material()};
    add(scene, rectangle({50, 0, 0}, {0.1f, 0, 0}, {0, 0.1f, 0}));
    return scene;
}

Camera along_z(float height) {
    Camera camera = look_at({0, 0, 5}, {0, 0, 0}, 30);
    camera.orthographic_height = height;
    return camera;
}

SurfaceVolumeParams params(std::uint32_t size, VolumeMode mode, std::uint32_t m = 4) {
    SurfaceVolumeParams p;
    p.surfaces.method = m == 1 ? AaMethod::none : AaMethod::adaptive;
    p.surfaces.metric = MetricKind::ockham;
    p.surfaces.resolve = Resolve::stratified;
    p.surfaces.order_kind = SampleOrder::optimal;
    p.surfaces.m = m;
    p.surfaces.export_counts = true;
    p.medium.width = p.medium.height = size;
    p.medium.mode = mode;
    p.medium.gather = false;
    p.medium.sobol = false;
    return p;
}

double psnr(const Image& a, const Image& b) { return image_error(a, b).psnr; }

/// In the plan, and not culled.
bool runs(SurfaceVolume& picture, std::string_view pass) {
    const std::vector<PassDecl>& passes = picture.executor().graph().declaration().passes;
    for (std::size_t i = 0; i < passes.size(); ++i)
        if (passes[i].name == pass) return !picture.executor().plan().passes[i].culled;
    return false;
}

class IsosurfaceSamples : public GpuTest {
protected:
    static Image after(SurfaceVolume& picture, int steps) {
        for (int i = 0; i < steps; ++i) picture.execute();
        picture.finish();
        return picture.picture();
    }
    static Image render(const Scene& scene, const Volume& volume, const TransferFunction& transfer,
        const VolumeView& view, const Camera& camera, const SurfaceVolumeParams& p, int steps) {
        const LitScene lit(device(), scene);
        const Image none;
        SurfaceVolume picture(
            device(), &lit, MediumSource{volume, transfer, none, view, {}}, camera, p);
        return after(picture, steps);
    }
};

TEST_F(IsosurfaceSamples, APlaneInFogIsLitByAllLamps) {
    Scene scene = hardly_any();
    const glm::dvec3 sun = glm::normalize(glm::dvec3(0.3, -0.2, -1.0)), lamp(0.2, 0.1, 1.5);
    scene.lights = {{.name = "sun",
                        .type = LightType::directional,
                        .direction = glm::vec3(sun),
                        .intensity = glm::vec3(2.0f)},
        {.name = "lamp",
            .type = LightType::point,
            .position = glm::vec3(lamp),
            .intensity = glm::vec3(3.0f)}};
    VolumeView view = lit_by(scene, absorbing(1.5f), glm::vec3(0.0f));
    view.surfaces = {{.value = 127.5}};
    Camera perspective = look_at({0.1f, 0.05f, 2.0f}, {0, 0, 0}, 6);
    for (const Camera& camera : {along_z(0.2f), perspective}) {
        const Image picture = render(
            scene, ramp(), everywhere(), view, camera, params(6, VolumeMode::caching, 1), 16);
        for (int y = 0; y < 6; ++y)
            for (int x = 0; x < 6; ++x) {
                // Where the ray through the pixel's centre meets z = 0, and its slant.
                const bool flat = camera.orthographic_height > 0;
                const double h = flat ? 0.1 : std::tan(glm::radians(3.0));
                const glm::dvec3 right =
                    glm::cross(glm::dvec3(camera.forward), glm::dvec3(camera.up));
                const glm::dvec3 aside = h * ((x + 0.5) / 3.0 - 1.0) * right +
                                         h * (1.0 - (y + 0.5) / 3.0) * glm::dvec3(camera.up);
                glm::dvec3 from(camera.position), way(camera.forward);
                (flat ? from : way) += aside;
                const glm::dvec3 at = from + way * (-from.z / way.z), to_lamp = lamp - at;
                const auto through = [](const glm::dvec3& w) {
                    return std::exp(-1.5 * 0.5 * glm::length(w) / std::abs(w.z));
                };
                const double distance2 = glm::dot(to_lamp, to_lamp);
                const double lit =
                    2.0 * -sun.z * through(sun) +
                    3.0 / distance2 * (to_lamp.z / std::sqrt(distance2)) * through(to_lamp);
                const double expected = 0.8 / kPi * lit * through(way);
                EXPECT_NEAR(
                    picture.plane(1)[static_cast<std::size_t>(6 * y + x)] / expected, 1.0, 2e-4)
                    << x << ' ' << y << (flat ? " orthographic" : " perspective");
            }
    }
}

TEST_F(IsosurfaceSamples, ItLooksAsWithoutMeshes) {
    // Shaded once for each sample here, at each step anew there.
    Scene scene = hardly_any();
    scene.lights = {{.name = "sun",
        .type = LightType::directional,
        .direction = glm::normalize(glm::vec3(0.6f, -0.5f, -0.7f)),
        .intensity = glm::vec3(3.0f)}};
    VolumeView view = lit_by(scene, absorbing(0), glm::vec3(0.3f));
    scene.background = view.environment;
    view.surfaces = {{.value = 127.5}};
    view.surface_gain = 0.9f;
    const Image none;
    const Camera camera = look_at({0.3f, 0.4f, 2.0f}, {0, 0, 0}, 20);
    for (const std::uint32_t shading : {SHADING_LAMBERT, SHADING_PHONG, SHADING_DISNEY}) {
        view.shading = shading;
        SurfaceVolumeParams p = params(48, VolumeMode::noncaching);
        const Image with = render(scene, ball(), everywhere(), view, camera, p, 1);
        p.medium.samples_per_step = 64;
        VolumeGi alone(device(), ball(), everywhere(), none, view, camera, p.medium);
        alone.execute();
        alone.finish();
        const Image without = alone.picture();
        double sum_with = 0, sum_without = 0;
        for (std::size_t i = 0; i < with.pixels(); ++i) {
            sum_with += with.plane(0)[i];
            sum_without += without.plane(0)[i];
        }
        EXPECT_NEAR(sum_with / sum_without, 1.0, 0.004) << shading;
        EXPECT_GT(psnr(with, without), 40.0) << shading;
    }
}

TEST_F(IsosurfaceSamples, TheSunAndTheCameraReachBeyondAllMeshes) {
    // A card before the ball is all that shadow map and depth would have to hold without it.
    Scene scene;
    scene.materials = {unlit_material()};
    add(scene, rectangle({-0.05f, -0.05f, 0.6f}, {0.1f, 0, 0}, {0, 0.1f, 0}));
    scene.lights = {{.name = "sun",
        .type = LightType::directional,
        .direction = glm::normalize(glm::vec3(0.3f, 0.0f, -1.0f)),
        .intensity = glm::vec3(3.0f),
        .casts_shadow = true}};
    VolumeView view = lit_by(scene, absorbing(0), glm::vec3(0.0f));
    view.surfaces = {{.value = 127.5}};
    const auto row = [&](bool shadow) {
        scene.lights[0].casts_shadow = shadow;
        const Image picture = render(scene, ball(), everywhere(), view, along_z(0.8f),
            params(64, VolumeMode::noncaching, 1), 1);
        const std::span<const float> red = picture.plane(0);
        return std::vector<float>(red.begin() + 64 * 32, red.begin() + 64 * 33);
    };
    const std::vector<float> with = row(true), without = row(false);
    EXPECT_EQ(with[41], 0.0f); // the card's shadow, at x = 0.113
    EXPECT_GT(without[41], 0.3f);
    EXPECT_EQ(with[23], without[23]);
    EXPECT_GT(with[23], 0.3f);
}

TEST_F(IsosurfaceSamples, CountsAntialiasTheirSilhouettesInOneStep) {
    Scene scene = hardly_any();
    scene.background = glm::vec3(0.8f);
    add(scene, rectangle({-0.05f, -2, 0.3f}, {0.1f, 0, 0}, {0, 4, 0})); // a bar before the ball
    add(scene,
        rectangle({-2, 0.0f, -0.1f}, {4, 0, 0}, {0, 0.03f, 0.2f})); // one that goes through it
    VolumeView view = absorbing(0);
    view.environment = glm::vec3(0.2f);
    view.surfaces = {{.value = 127.5}};
    const LitScene lit(device(), scene);
    const Volume field = ball();
    const Image none;
    const MediumSource medium{field, everywhere(), none, view, {}};
    SurfaceVolumeParams p = params(64, VolumeMode::noncaching);
    const Camera camera = along_z(0.8f);
    SurfaceVolume picture(device(), &lit, medium, camera, p);
    const Image first = after(picture, 1);
    EXPECT_TRUE(equal(first, after(picture, 15))) << "steps have nothing to add";
    // One sample inside and outside, more on edges.
    const Image counts = picture.executor().read(picture.medium()->meshes()->sample_count());
    const auto k = [&](int x, int y) {
        return counts.plane(0)[static_cast<std::size_t>(64 * y + x)];
    };
    EXPECT_EQ(k(2, 2), 1.0f);
    EXPECT_EQ(k(40, 24), 1.0f);
    int edges = 0; // of the ball, radius 20 pixels about the centre; the bar hides four of 16
    for (int i = 0; i < 16; ++i) {
        const double angle = (i + 0.5) * kPi / 8;
        double most = 1;
        for (double r = 18; r < 22; r += 0.25) {
            most = std::max<double>(most, k(static_cast<int>(32 + r * std::cos(angle)),
                                              static_cast<int>(32 - r * std::sin(angle))));
        }
        edges += most > 1 ? 1 : 0;
    }
    EXPECT_EQ(edges, 12);
    EXPECT_LT(*picture.sample_percent(), 25.0);
    p.surfaces.method = AaMethod::ssaa;
    SurfaceVolume all(device(), &lit, medium, camera, p);
    EXPECT_GT(psnr(first, after(all, 1)), 42.0);
    p.surfaces.method = AaMethod::none;
    SurfaceVolume aliased(device(), &lit, medium, camera, p);
    EXPECT_LT(psnr(after(aliased, 1), all.picture()), 32.0);
}

TEST_F(IsosurfaceSamples, PathsChangeTheSmoothPictureByTheirLightAlone) {
    // A convex body in even light: every path brings what its surface is shaded with.
    Scene scene = hardly_any();
    scene.background = glm::vec3(0.2f);
    VolumeView view = absorbing(0);
    view.environment = glm::vec3(1.0f);
    view.surfaces = {{.value = 127.5}};
    const auto one_step = [&](VolumeMode mode, AaMethod method) {
        SurfaceVolumeParams p = params(48, mode);
        p.surfaces.method = method;
        return render(scene, ball(), everywhere(), view, along_z(0.8f), p, 1);
    };
    const Image all = one_step(VolumeMode::noncaching, AaMethod::ssaa);
    const double smooth = psnr(one_step(VolumeMode::noncaching, AaMethod::adaptive), all);
    const double traced = psnr(one_step(VolumeMode::path, AaMethod::adaptive), all);
    EXPECT_GT(smooth, 100.0);
    EXPECT_GT(traced, 50.0); // of windows with more than four labels a ray may see a neighbour
}

TEST_F(IsosurfaceSamples, StepsAreInThePlanOnlyWhereTheyHaveSomethingToAdd) {
    const LitScene lit(device(), hardly_any());
    const Volume field = ball();
    const Image none;
    VolumeView view = absorbing(0);
    view.environment = glm::vec3(1.0f);
    view.surfaces = {{.value = 127.5}};
    for (const VolumeMode mode : {VolumeMode::noncaching, VolumeMode::caching, VolumeMode::path}) {
        SurfaceVolume picture(device(), &lit, MediumSource{field, everywhere(), none, view, {}},
            along_z(1), params(24, mode));
        const Image still = after(picture, 2);
        EXPECT_EQ(runs(picture, "over_meshes"), mode == VolumeMode::path) << name_of(mode);
        EXPECT_EQ(runs(picture, "mesh_ends"), mode == VolumeMode::path) << name_of(mode);
        VolumeView foggy = view;
        foggy.density_scale = 1;
        picture.medium()->set_view(foggy);
        const Image fog = after(picture, 2);
        EXPECT_TRUE(runs(picture, "over_meshes")) << name_of(mode);
        EXPECT_FALSE(equal(fog, still));
        TransferFunction clear{{{.value = 0, .opacity = 0}, {.value = 255, .opacity = 0}}};
        picture.medium()->set_transfer(clear);
        EXPECT_EQ(runs(picture, "over_meshes"), mode == VolumeMode::path) << name_of(mode);
        picture.medium()->set_transfer(everywhere());
        EXPECT_TRUE(runs(picture, "over_meshes")) << name_of(mode);
        picture.medium()->set_view(view);
        if (mode == VolumeMode::path) continue;
        EXPECT_TRUE(equal(after(picture, 1), still)) << name_of(mode);
    }
}

TEST_F(IsosurfaceSamples, TranslucentOnesAreComposedBeforeOpaqueOnes) {
    VolumeView view = absorbing(1);
    view.environment = glm::vec3(1.0f);
    view.surfaces = {{.value = 127.5}, {.value = 63.75, .opacity = 0.25f}};
    view.surfaces[0].material.base_color = glm::vec3(0.6f);
    view.surfaces[1].material.base_color = glm::vec3(0.2f);
    // Fog of extinction 1 to the first, at voxel 3.75, and on to the second, in the middle.
    const double before = (3.75 + 0.5) / 16, between = 0.5 - before;
    const double expected = std::exp(-before) * (0.25 * 0.2 + 0.75 * std::exp(-between) * 0.6);
    const Image composed = render(hardly_any(), ramp(), everywhere(), view, along_z(0.2f),
        params(6, VolumeMode::caching, 1), 16);
    for (const float value : composed.plane(0)) EXPECT_NEAR(value, expected, 2e-4);
    // Traced, each path meets one of them or is absorbed.
    SurfaceVolumeParams p = params(16, VolumeMode::noncaching, 1);
    p.medium.samples_per_step = 16;
    const Image traced = render(hardly_any(), ramp(), everywhere(), view, along_z(0.2f), p, 1);
    double sum = 0, square = 0;
    for (const float value : traced.plane(0)) sum += value, square += value * value;
    const double n = 256, mean = sum / n;
    EXPECT_LT(z_of({mean, std::sqrt((square / n - mean * mean) / n)}, expected), z_limit(1));
}

TEST_F(IsosurfaceSamples, AWhiteFurnaceStaysWhite) {
    Scene scene = hardly_any();
    scene.background = scene.ambient = glm::vec3(1.0f);
    VolumeView view = absorbing(4);
    view.albedo = 1;
    view.environment = glm::vec3(1.0f);
    view.surfaces = {{.value = 127.5}};
    view.surfaces[0].material.base_color = glm::vec3(1.0f);
    const Camera camera = look_at({0.4f, 0.3f, 2.2f}, {0, 0, 0}, 32);
    // Only paths know what of the sky a surface sees through fog.
    const Image traced =
        render(scene, ball(), everywhere(), view, camera, params(24, VolumeMode::path), 3);
    for (const float value : traced.plane(1)) ASSERT_NEAR(value, 1.0, 1e-5);
}

TEST_F(IsosurfaceSamples, PathsAgreeWithThoseOfVolumesAlone) {
    // Light that is scattered between fog and surface: the local shading of samples leaves the
    // mean.
    Scene scene = hardly_any();
    scene.lights = {{.name = "sun",
        .type = LightType::directional,
        .direction = glm::normalize(glm::vec3(0.6f, -0.5f, -0.7f)),
        .intensity = glm::vec3(2.0f)}};
    VolumeView view = lit_by(scene, absorbing(3), glm::vec3(0.3f));
    scene.background = view.environment;
    view.albedo = 0.9f;
    view.surfaces = {{.value = 127.5}};
    const Camera camera = look_at({0.3f, 0.4f, 2.0f}, {0, 0, 0}, 30);
    SurfaceVolumeParams p = params(16, VolumeMode::path);
    p.medium.samples_per_step = 64;
    const Image none;
    double sum = 0, square = 0;
    constexpr int kSeeds = 12;
    for (int seed = 1; seed <= kSeeds; ++seed) {
        view.seed = static_cast<std::uint32_t>(seed);
        const Image with = render(scene, ball(), everywhere(), view, camera, p, 1);
        view.seed += 100;
        VolumeGi alone(device(), ball(), everywhere(), none, view, camera, p.medium);
        alone.execute();
        alone.finish();
        const Image without = alone.picture();
        double mean = 0;
        for (std::size_t i = 0; i < with.pixels(); ++i)
            mean += (with.plane(0)[i] - without.plane(0)[i]) / static_cast<double>(with.pixels());
        sum += mean;
        square += mean * mean;
    }
    const double mean = sum / kSeeds;
    const double error = std::sqrt((square / kSeeds - mean * mean) / (kSeeds - 1));
    EXPECT_LT(error, 0.002);
    EXPECT_LT(std::abs(mean), 3.5 * error + 1e-4); // 12 values: t, not z
}

TEST_F(IsosurfaceSamples, MirroredDataAndCamerasInTheBoxSeeTheSame) {
    Volume mirrored = ball();
    mirrored.direction[0].x = -1;
    VolumeView view = absorbing(0);
    view.environment = glm::vec3(1.0f);
    view.surfaces = {{.value = 127.5}};
    const SurfaceVolumeParams p = params(24, VolumeMode::noncaching);
    for (const float z : {2.0f, 0.4f}) { // outside, inside
        const Camera camera = look_at({0, 0, z}, {0, 0, 0}, 40);
        const Image a = render(hardly_any(), ball(), everywhere(), view, camera, p, 1);
        const Image b = render(hardly_any(), mirrored, everywhere(), view, camera, p, 1);
        EXPECT_NEAR(a.plane(0)[24 * 12 + 12], 0.8f, 1e-5f) << z;
        EXPECT_GT(psnr(a, b), 45.0) << z;
    }
}

TEST_F(IsosurfaceSamples, OtherSearchesAreRefused) {
    const LitScene lit(device(), hardly_any());
    const Volume field = ball();
    const Image none;
    VolumeView view = absorbing(0);
    view.surfaces = {{.value = 127.5}};
    SurfaceVolumeParams p = params(8, VolumeMode::caching);
    p.medium.search = SurfaceSearch::march;
    const std::string error = error_of([&] {
        SurfaceVolume(
            device(), &lit, MediumSource{field, everywhere(), none, view, {}}, along_z(1), p);
    });
    EXPECT_NE(error.find("--surface-search"), std::string::npos) << error;
}

TEST_F(IsosurfaceSamples, NothingIsInThePlanWhereNoneIsOpaque) {
    const LitScene lit(device(), hardly_any());
    const Volume field = ball();
    const Image none;
    const auto plan = [&](const VolumeView& view) {
        SurfaceVolume picture(device(), &lit, MediumSource{field, everywhere(), none, view, {}},
            along_z(1), params(8, VolumeMode::noncaching));
        picture.execute();
        picture.finish();
        return std::pair(
            explain(picture.executor().graph().declaration(), picture.executor().plan()),
            picture.executor().pipeline_count());
    };
    VolumeView view = absorbing(1);
    const auto [without, fewer] = plan(view);
    view.surfaces = {{.value = 127.5, .opacity = 0.5f}};
    const auto [translucent, as_many] = plan(view);
    view.surfaces[0].opacity = 1;
    const auto [opaque, more] = plan(view);
    EXPECT_NE(without.find("gbuffer, isosurfaces"), std::string::npos);
    EXPECT_NE(translucent.find("no isosurface is opaque"), std::string::npos);
    EXPECT_EQ(opaque.find("gbuffer, isosurfaces"), std::string::npos);
    EXPECT_NE(opaque.find("and opaque isosurfaces"), std::string::npos);
    EXPECT_EQ(more, as_many + 1);
    EXPECT_LE(fewer, as_many);
}

} // namespace
} // namespace ockham::test

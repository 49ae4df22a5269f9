// SPDX-License-Identifier: Apache-2.0
// Expectations of transport where several parts meet: sun and sky together, light on surfaces that
// scatter, and pictures and cells of the cache. By z-tests with fixed seeds.
#include "framework/core/rng.hpp"
#include "tests/support/cache_bench.hpp"
#include "tests/support/path_case.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <vector>

namespace ockham::test {
namespace {

constexpr double kPi = std::numbers::pi;

class TransportTest : public PathTest {};

/// Dark but for two windows and a lamp.
Image sky() {
    Image map(8, 4, {"R", "G", "B"});
    Pcg32 rng(3);
    for (int c = 0; c < 3; ++c)
        for (float& texel : map.plane(c)) texel = std::pow(rng.uniform(), 4.0f);
    for (int c = 0; c < 3; ++c) map.at(5, 1, c) = 10.0f + static_cast<float>(c);
    return map;
}

TEST_F(TransportTest, SunAndSkyAddUp) {
    Case both = cube(4, 0.8f, 0.6f);
    both.transfer = linear_transfer({1.0, 0.9, 0.6});
    both.samples = 256;
    both.options.environment = sky();
    both.options.view.light_direction = {0.5f, -0.7f, -0.4f};
    both.options.view.light_irradiance = {3, 2, 4};
    Case sun = both;
    sun.options.environment = {};
    sun.options.view.environment = glm::vec3(0.0f);
    sun.options.view.seed = 2;
    Case light = both;
    light.options.view.light_irradiance = glm::vec3(0.0f);
    light.options.view.seed = 3;
    const auto together = trace(both).mean, of_sun = trace(sun).mean, of_sky = trace(light).mean;
    const Family family(3);
    for (std::size_t c = 0; c < 3; ++c) {
        const Estimate sum{
            of_sun[c].mean + of_sky[c].mean, std::hypot(of_sun[c].error, of_sky[c].error)};
        family.expect(together[c], sum, fmt::format("channel {}", c));
        EXPECT_LT(together[c].error, 0.01 * together[c].mean);
    }
}

/// A ball with one surface of radius 0.2 in vacuum.
Case solid_ball() {
    Case it;
    it.volume = float_volume(glm::uvec3(24),
        [](glm::uvec3 v) { return 1 - glm::length((glm::dvec3(v) + 0.5) / 24.0 - 0.5) / 0.4; });
    it.options.view.density_scale = 0;
    VolumeView::Surface surface{.value = 0.5};
    surface.material.base_color = glm::vec3(0.6f);
    it.options.view.surfaces.push_back(surface);
    it.options.width = it.options.height = 32;
    it.options.camera = look_at({0, 0, 2}, {0, 0, 0}, 30);
    it.options.camera.orthographic_height = 0.5f;
    it.samples = 64;
    return it;
}

TEST_F(TransportTest, SunlitBallsReflectAsLambertsSphere) {
    Case it = solid_ball();
    const double angle = 1.1; // between the ways to the sun and to the eye
    it.options.view.environment = glm::vec3(0.0f);
    it.options.view.light_direction = {std::sin(angle), 0, -std::cos(angle)};
    it.options.view.light_irradiance = glm::vec3(3.0f);
    it.options.view.max_bounces = 1; // no light from one facet to another
    const Result scattering = trace(it);
    it.params.mode = PathMode::noncaching;
    it.options.view.seed = 2;
    const Result local = trace(it);
    const Family family(2);
    family.expect(scattering.mean[0], local.mean[0], "path and noncaching");
    // Of the part of the picture that the ball covers, the one of voxels being a little smaller;
    // its normals are those of a sphere to a few thousandths.
    const double phase = (std::sin(angle) + (kPi - angle) * std::cos(angle)) * 2 / (3 * kPi);
    const double truth = scattering.alpha * 0.6 * 3 / kPi * phase;
    family.expect(scattering.mean[0], {truth, 0.002 * truth}, "Lambert's sphere");
    EXPECT_NEAR(scattering.alpha, kPi * 0.2 * 0.2 / (0.5 * 0.5), 0.02);
}

TEST_F(TransportTest, GlossySurfacesSeeTheSkyThatTheyMeetByChance) {
    Case it = solid_ball();
    it.options.environment = sky();
    it.options.view.shading = SHADING_DISNEY;
    shader::IsoMaterial& material = it.options.view.surfaces[0].material;
    material.specular = 1;
    material.metallic = 0.3f;
    material.roughness = 0.4f;
    material.clearcoat = 1;
    material.clearcoat_gloss = 0.3f;
    const auto sampled = trace(it).mean;
    it.options.view.seed = 2;
    it.params.nee = false;
    it.samples = 768; // few meet the sun
    const auto met = trace(it).mean;
    const Family family(3);
    for (std::size_t c = 0; c < 3; ++c) {
        family.expect(sampled[c], met[c], fmt::format("channel {}", c));
        EXPECT_LT(met[c].error, 0.01 * met[c].mean);
    }
}

TEST_F(TransportTest, CellsOfAnIsothermalFurnaceKeepItsRadiance) {
    Pcg32 rng(6);
    const Volume volume = float_volume(glm::uvec3(8, 7, 6),
        [&](glm::uvec3) { return static_cast<double>(std::pow(rng.uniform(), 2.0f)); });
    const glm::dvec3 glow(0.7, 1.4, 0.35);
    VolumeView view;
    view.density_scale = 12;
    view.environment = glow;
    CacheBench bench(device(), volume, linear_transfer({0.5, 0.8, 0.2}, glow), view,
        {.scale = 2, .format = CacheFormat::fp32, .target_error = 0, .paths = 256});
    bench.execute(14);
    const std::vector<CachedCell> cells = bench.cells();
    const std::vector<shader::CacheSum> sums = bench.sums();
    ASSERT_EQ(bench.size.slots, cells.size());
    const Family family(cells.size());
    const double radiance = glm::dot(glow, glm::dvec3(0.2126, 0.7152, 0.0722));
    for (std::size_t i = 0; i < cells.size(); ++i) {
        ASSERT_TRUE(cells[i].phi);
        const double n = sums[i].count;
        ASSERT_GE(n, 250);
        const double mean = glm::dot(*cells[i].phi, glm::dvec3(0.2126, 0.7152, 0.0722));
        const double variance = std::max(double{sums[i].square} / n - mean * mean, 0.0);
        const Estimate truth{radiance, 1e-6}; // of rounding: few paths differ
        family.expect({mean, std::sqrt(variance / n)}, truth, fmt::format("cell {}", i));
    }
}

TEST_F(TransportTest, ACubeSeenThroughTheCacheHasTheValuesOfAnIndependentTracer) {
    EXPECT_NEAR(gathered(cube(4, 1), 16, 0.02f).mean, 1, 1e-5);
    // Nothing is scattered, so that the cache does not matter.
    EXPECT_LE(z_of(gathered(cube(4, 0), 8, 1e6f), Estimate{0.056846, 5e-7}), z_limit(1));
    // Cells as thick as 32 along a side of the cube of extinction 4.
    const Estimate mean = gathered(cube(2, 0.8f), 16, 0.02f);
    EXPECT_LE(std::abs(mean.mean - 0.7258), 3 * mean.error + 1e-4)
        << mean.mean << " +- " << mean.error;
}

} // namespace
} // namespace ockham::test

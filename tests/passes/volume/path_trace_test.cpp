// SPDX-License-Identifier: Apache-2.0
// Path tracing against closed forms, tables of radiative transfer and an analog twin, by z-tests
// with fixed seeds; and its promises: furnaces, budgets, seeds, statistics.
#include "framework/core/rng.hpp"
#include "tests/reference/analog_tracer.hpp"
#include "tests/support/path_case.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

namespace ockham::test {
namespace {

constexpr double kPi = std::numbers::pi;

class PathTraceTest : public PathTest {};

TEST_F(PathTraceTest, CubeInWhiteLightHasTheValuesOfAnIndependentTracer) {
    struct Row {
        float sigma, albedo, g;
        Estimate truth;
    };
    // Analog Monte Carlo by another program; the last one is a quadrature.
    const Row rows[] = {{4, 1.0f, 0, {1.0, 0}}, {4, 0.8f, 0, {0.5610, 1e-4}},
        {4, 0.5f, 0, {0.2737, 1e-4}}, {4, 0.8f, 0.6f, {0.5414, 1e-4}}, {2, 0.8f, 0, {0.7258, 1e-4}},
        {4, 0.0f, 0, {0.056846, 5e-7}}};
    for (const Row& row : rows) {
        SCOPED_TRACE(fmt::format("sigma {}, albedo {}, g {}", row.sigma, row.albedo, row.g));
        const Estimate mean = trace(cube(row.sigma, row.albedo, row.g)).mean[0];
        EXPECT_LE(mean.error, 0.0005);
        EXPECT_LE(z_of(mean, row.truth), z_limit(std::size(rows)))
            << mean.mean << " +- " << mean.error;
    }
}

/// A field that is different in every voxel, in [0, 1], in a box with sides 1 : 0.7 : 0.9.
Volume rough_volume() {
    Pcg32 rng(5);
    Volume volume = float_volume(
        glm::uvec3(10, 7, 6), [&](glm::uvec3) { return std::pow(rng.uniform(), 2.0f); });
    volume.spacing_mm = {1, 1, 1.5};
    return volume;
}

Case rough(glm::dvec3 color = glm::dvec3(1.0), glm::dvec3 emission = glm::dvec3(0.0)) {
    Case it;
    it.volume = rough_volume();
    it.transfer = linear_transfer(color, emission);
    it.options.view.density_scale = 12;
    it.options.width = it.options.height = 24;
    return it;
}

TEST_F(PathTraceTest, WhiteFurnaceIsExactForAnyFieldAndPhaseFunction) {
    for (const float g : {0.0f, 0.7f, -0.95f}) {
        for (const bool global : {false, true}) {
            SCOPED_TRACE(fmt::format("g = {}, {} majorant", g, global ? "one" : "local"));
            Case it = rough();
            it.options.view.phase_g = g;
            it.global_majorant = global;
            it.samples = 16;
            const Result result = trace(it);
            for (std::size_t i = 0; i < result.sum.size(); ++i)
                ASSERT_EQ(i % 4 < 3 ? result.sum[i] : 16.0f, 16.0f) << "pixel " << i / 4;
            EXPECT_GT(result.alpha, 0.2);
        }
    }
}

TEST_F(PathTraceTest, ExtinctionOfTheMajorantItselfIsNoNumberOutOfRange) {
    Case it = cube(50, 1); // every tentative collision is real
    it.samples = 16;
    const Result result = trace(it);
    for (std::size_t i = 0; i < result.sum.size(); i += 4) ASSERT_EQ(result.sum[i], 16.0f);
}

TEST_F(PathTraceTest, IsothermalFurnaceKeepsItsRadiance) {
    Case it = rough({0.9, 0.8, 0.3}, glm::dvec3(0.7));
    it.options.view.environment = glm::vec3(0.7f);
    it.options.view.phase_g = 0.4f;
    it.samples = 128;
    const Result result = trace(it);
    // Paths differ only where roulette is played, after many scatterings; the rest is rounding.
    for (const Estimate& mean : result.mean) {
        Family(3).expect(mean, Estimate{0.7, 1e-6}, "furnace");
        EXPECT_LT(mean.error, 1e-4);
    }
}

TEST_F(PathTraceTest, NoDensityShowsTheEnvironment) {
    for (const double value : {0.0, 1.0}) {
        Case it = cube(0, 0.5f);
        it.volume = float_volume(glm::uvec3(4), [&](glm::uvec3 v) { return v.x * value; });
        it.transfer = {{{.value = 0, .opacity = 0}}};
        it.options.view.environment = {0.25f, 0.5f, 2.0f};
        it.samples = 4;
        const Result result = trace(it);
        for (std::size_t i = 0; i < result.sum.size(); i += 4) {
            ASSERT_EQ(result.sum[i], 1.0f);
            ASSERT_EQ(result.sum[i + 1], 2.0f);
            ASSERT_EQ(result.sum[i + 2], 8.0f);
            ASSERT_EQ(result.sum[i + 3], 0.0f);
        }
    }
}

// Nodes and weights of Gauss' quadrature over [0, 1], for cosines: int f(mu) 2 mu dmu.
constexpr std::array<std::pair<double, double>, 5> kCosines{
    {{0.953089923, 0.118463443}, {0.769234655, 0.239314335}, {0.5, 0.284444444},
        {0.230765345, 0.239314335}, {0.046910077, 0.118463443}}};

/// Looks at the middle of the box, with this cosine to +y.
Camera slanted_view(double mu) {
    const auto sine = static_cast<float>(std::sqrt(1 - mu * mu));
    Camera camera = look_at({-2 * sine, 2 * static_cast<float>(mu), 0}, {0, 0, 0}, 30);
    camera.orthographic_height = 0.002f;
    return camera;
}

/// The same with +z for +y, for environment maps have their zenith there.
Camera upright(Camera camera) {
    for (glm::vec3* const v : {&camera.position, &camera.forward, &camera.up})
        std::swap(v->y, v->z);
    return camera;
}

/// From kCosines' views: what a diffuse illumination gives.
template <class View>
std::array<Estimate, 3> diffuse(View view) {
    std::array<Estimate, 3> sum{};
    for (const auto& [mu, weight] : kCosines) {
        const Result result = view(mu);
        for (std::size_t c = 0; c < 3; ++c) {
            sum[c].mean += 2 * mu * weight * result.mean[c].mean;
            sum[c].error = std::hypot(sum[c].error, 2 * mu * weight * result.mean[c].error);
        }
    }
    return sum;
}

TEST_F(PathTraceTest, SlabsReflectAndTransmitAsTheTablesOfAddingAndDoubling) {
    struct Row {
        double albedo, depth;
        std::array<double, 4> values; // diffuse R and T, normal R and T
    };
    const Row rows[] = {{1, 0.5, {.29583, .70417, .20251, .79749}},
        {1, 1, {.44659, .55341, .34133, .65867}}, {1, 2, {.60994, .39006, .51751, .48248}},
        {1, 4, {.75402, .24597, .69092, .30907}}, {1, 8, {.85845, .14152, .82178, .17818}},
        {.9, 1, {.35271, .47475, .26741, .59162}}, {.9, 2, {.43715, .26558, .36165, .35650}},
        {.9, 4, {.47318, .09056, .40814, .12852}}, {.5, 1, {.13417, .30671, .09912, .44606}},
        {.5, 2, {.14509, .10706, .11283, .18932}}};
    const std::array<double, 3> albedos{1, .9, .5};
    const Family family(std::size(rows) * 4);
    for (const double depth : {0.5, 1.0, 2.0, 4.0, 8.0}) {
        const auto view = [&](double mu, bool below) {
            Case it;
            it.volume = float_volume({64, 64, 1}, [](glm::uvec3) { return 1.0; });
            it.transfer = linear_transfer({albedos[0], albedos[1], albedos[2]});
            it.options.view.density_scale = static_cast<float>(64 * depth);
            it.options.width = it.options.height = 16;
            it.options.camera = upright(slanted_view(mu));
            it.options.environment = Image(4, 2, {"R", "G", "B"}); // light from above or below
            for (int x = 0; x < 4; ++x)
                for (int c = 0; c < 3; ++c) it.options.environment.at(x, below ? 1 : 0, c) = 1;
            it.samples = mu == 1 ? 256 : 64;
            it.options.view.seed = static_cast<std::uint32_t>(1000 * depth + 100 * mu) + below;
            return trace(it);
        };
        std::array<std::array<Estimate, 3>, 4> found;
        for (int below = 0; below < 2; ++below) {
            found[static_cast<std::size_t>(below)] =
                diffuse([&](double mu) { return view(mu, below != 0); });
            found[static_cast<std::size_t>(2 + below)] = view(1, below != 0).mean;
        }
        for (const Row& row : rows) {
            if (row.depth != depth) continue;
            const auto c = static_cast<std::size_t>(
                std::find(albedos.begin(), albedos.end(), row.albedo) - albedos.begin());
            const char* names[] = {"R diffuse", "T diffuse", "R normal", "T normal"};
            for (std::size_t i = 0; i < 4; ++i) {
                // The tables are good to 4e-5, the quadrature to 8e-5.
                family.expect(found[i][c], {row.values[i], 1e-4},
                    fmt::format("albedo {}, depth {}: {}", row.albedo, depth, names[i]));
            }
        }
    }
}

/// Chandrasekhar's H function for isotropic scattering, and what follows for a half-space.
struct HalfSpace {
    double albedo, h_half, h_one;    // H(.5), H(1)
    double normal, slanted, diffuse; // plane albedo for cosines 1 and .5, spherical albedo
};
constexpr HalfSpace kHalfSpaces[] = {{.1, 1.028922, 1.036816, .016390, .023879, .021698},
    {.3, 1.097559, 1.126844, .057214, .081716, .074451},
    {.5, 1.187735, 1.251260, .115226, .160144, .146544},
    {.7, 1.317945, 1.444746, .208680, .278132, .256557},
    {.8, 1.413263, 1.598220, .285255, .367970, .341867},
    {.9, 1.556034, 1.850099, .414947, .507939, .478024},
    {.95, 1.671788, 2.077124, .535541, .626177, .596669},
    {.99, 1.848601, 2.472793, .752721, .815140, .794564},
    {.999, 1.958687, 2.756073, .912845, .938061, .929713}};

/// A cube so dense that it is one, with three albedos as colours; seen from above.
Case half_space(std::size_t first, double mu) {
    Case it;
    it.transfer = linear_transfer(
        {kHalfSpaces[first].albedo, kHalfSpaces[first + 1].albedo, kHalfSpaces[first + 2].albedo});
    it.options.view.density_scale = 1000;
    it.options.width = it.options.height = 16;
    it.options.camera = slanted_view(mu);
    it.options.camera.position.y += 0.5f; // looks at the middle of the upper face
    it.samples = 256;
    it.options.view.seed =
        static_cast<std::uint32_t>(1000 * mu + static_cast<double>(first)); // independent runs
    return it;
}

TEST_F(PathTraceTest, HalfSpacesReflectAsTheHFunctionSays) {
    const Family family(std::size(kHalfSpaces) * 3);
    for (std::size_t first = 0; first < std::size(kHalfSpaces); first += 3) {
        const auto normal = trace(half_space(first, 1)).mean;
        const auto slanted = trace(half_space(first, 0.5)).mean;
        const auto all = diffuse([&](double mu) {
            Case it = half_space(first, mu);
            it.samples = 64;
            return trace(it);
        });
        for (std::size_t c = 0; c < 3; ++c) {
            const HalfSpace& truth = kHalfSpaces[first + c];
            family.expect(normal[c], truth.normal, fmt::format("albedo {}", truth.albedo));
            family.expect(slanted[c], truth.slanted, fmt::format("albedo {}, .5", truth.albedo));
            family.expect(
                all[c], {truth.diffuse, 1e-4}, fmt::format("albedo {}, diffuse", truth.albedo));
        }
    }
}

TEST_F(PathTraceTest, SunlitHalfSpacesHaveChandrasekharsRadiance) {
    const std::pair<double, double> angles[] = {{1, 1}, {1, 0.5}, {0.5, 1}}; // view, sun
    const Family family(std::size(kHalfSpaces) * std::size(angles));
    for (std::size_t first = 0; first < std::size(kHalfSpaces); first += 3) {
        for (const auto& [mu, sun] : angles) {
            Case it = half_space(first, mu);
            it.options.view.environment = glm::vec3(0.0f);
            it.options.view.light_direction = {0, -sun, std::sqrt(1 - sun * sun)};
            it.options.view.light_irradiance = glm::vec3(static_cast<float>(kPi));
            it.options.view.seed += static_cast<std::uint32_t>(5000 * sun);
            const auto found = trace(it).mean;
            for (std::size_t c = 0; c < 3; ++c) {
                const HalfSpace& h = kHalfSpaces[first + c];
                const double truth = h.albedo / 4 * sun / (mu + sun) *
                                     (mu == 1 ? h.h_one : h.h_half) *
                                     (sun == 1 ? h.h_one : h.h_half);
                family.expect(found[c], truth, fmt::format("albedo {}, {}, {}", h.albedo, mu, sun));
            }
        }
    }
}

TEST_F(PathTraceTest, SingleScatteringHasItsClosedForms) {
    const auto lit = [&](glm::vec3 from, glm::vec3 light, float sigma, float irradiance) {
        Case it = cube(sigma, 0.8f);
        it.options.view.environment = glm::vec3(0.0f);
        it.options.view.light_direction = light;
        it.options.view.light_irradiance = glm::vec3(irradiance);
        it.options.view.max_bounces = 1;
        it.options.camera = flat_view(from, 0.0005f);
        it.samples = 256;
        return trace(it).mean[0];
    };
    const Family family(5);
    const auto pi = static_cast<float>(kPi);
    const double p = 1 / (4 * kPi);
    // w p E (1 - exp(-2 s D)) / 2, w p E s D exp(-s D), w p E exp(-s x) (1 - exp(-s D)).
    family.expect(lit({0, 0, -2}, {0, 0, 1}, 2, 1), .0312480, "with the light");
    family.expect(lit({0, 0, 2}, {0, 0, 1}, 2, 1), .0172314, "against the light");
    family.expect(lit({0, 0, -2}, {1, 0, 0}, 2, 1), .0202504, "from the side");
    family.expect(
        lit({0, 0, -2}, {0, 0, 1}, 2, pi), .8 * p * kPi / 2 * (1 - std::exp(-4)), "lit side");
    family.expect(lit({0, 0, 2}, {0, 0, 1}, 2, pi), .8 * p * kPi * 2 * std::exp(-2), "far side");
}

TEST_F(PathTraceTest, TransmittanceIsBeersLaw) {
    const Family family(5);
    const auto seen = [&](Case it, Camera camera) {
        it.options.camera = camera;
        it.samples = 256;
        return trace(it).mean[0];
    };
    family.expect(seen(cube(4, 0), flat_view({0, 0, 2}, 0.0005f)), std::exp(-4), "along z");
    // From edge to edge: the diagonal of a face.
    family.expect(seen(cube(2, 0), flat_view({2, 0, 2}, 0.0001f)),
        std::exp(-2 * std::numbers::sqrt2), "diagonal");
    Case capped = cube(2, 1); // no scattering allowed: only what does not collide gets through
    capped.options.view.max_bounces = 0;
    family.expect(seen(capped, flat_view({0, 0, 2}, 0.0005f)), std::exp(-2), "no bounces");
    Case slab = cube(0, 0);
    slab.volume = float_volume({64, 1, 64}, [](glm::uvec3) { return 1.0; });
    slab.options.view.density_scale = 64;
    family.expect(seen(slab, slanted_view(0.5)), std::exp(-2), "slanted slab");
    Case inside = cube(2, 0);
    inside.options.camera = Camera{}; // from the middle of the cube
    inside.options.camera.orthographic_height = 0.0005f;
    family.expect(seen(inside, inside.options.camera), std::exp(-1), "from inside");
}

/// What the analog twin sees through the same pixels.
std::array<Estimate, 3> analog(const Case& it, std::size_t histories) {
    const reference::AnalogTracer tracer(it.volume, it.transfer, it.options.view);
    const Camera& camera = it.options.camera;
    std::mt19937_64 random(9);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    const glm::dvec3 forward(camera.forward), up(camera.up);
    const glm::dvec3 right = glm::cross(forward, up);
    const bool flat = camera.orthographic_height > 0;
    const double half = flat ? 0.5 * camera.orthographic_height
                             : std::tan(glm::radians(0.5 * camera.fov_y_degrees));
    std::array<Estimate, 3> result;
    for (int c = 0; c < 3; ++c) {
        double sum = 0, squares = 0;
        for (std::size_t i = 0; i < histories; ++i) {
            const double x = uniform(random), y = uniform(random);
            const glm::dvec3 aside = half * (x * right + y * up);
            const glm::dvec3 origin =
                glm::dvec3(camera.position) + (flat ? aside : glm::dvec3(0.0));
            const double value = tracer.history(
                origin, glm::normalize(forward + (flat ? glm::dvec3(0.0) : aside)), c, random);
            sum += value;
            squares += value * value;
        }
        const auto n = static_cast<double>(histories);
        const double mean = sum / n;
        result[static_cast<std::size_t>(c)] = {mean, std::sqrt((squares / n - mean * mean) / n)};
    }
    return result;
}

TEST_F(PathTraceTest, AnalogTracerSeesTheSame) {
    std::vector<Case> cases;
    Case lit = rough({0.9, 0.6, 0.2}); // everything at once: sun, sky, colours, a cut
    lit.options.view.light_direction = {0.3f, 0.8f, -0.6f};
    lit.options.view.light_irradiance = {3.0f, 2.0f, 1.0f};
    lit.options.view.environment = {0.1f, 0.3f, 0.5f};
    lit.options.view.phase_g = 0.5f;
    lit.options.view.clip_planes = {glm::vec4(0.6f, 0.0f, 0.8f, 0.2f)};
    lit.options.view.crop_max = {0.9f, 1.0f, 0.8f};
    cases.push_back(lit);
    Case glowing = rough({0.5, 0.9, 0.99}, {0.5, 1.0, 2.0});
    glowing.options.view.phase_g = -0.6f;
    glowing.options.view.max_bounces = 3;
    glowing.options.camera = look_at({0.1f, 0.05f, 0.2f}, {0.4f, -0.3f, 0.0f}, 60); // in the medium
    cases.push_back(glowing);
    // Of 2,000,000 histories, six minutes; a few of them here keep the numbers honest.
    const Estimate truths[2][3] = {{{0.120305, 7.4e-5}, {0.261920, 7.7e-5}, {0.393138, 1.45e-4}},
        {{0.597577, 1.66e-4}, {0.669834, 3.33e-4}, {0.543823, 3.89e-4}}};
    const Family family(cases.size() * 6);
    for (std::size_t i = 0; i < cases.size(); ++i) {
        cases[i].samples = 512;
        const auto found = trace(cases[i]).mean;
        const auto few = analog(cases[i], 20000);
        for (std::size_t c = 0; c < 3; ++c) {
            family.expect(found[c], truths[i][c], fmt::format("channel {}", c));
            family.expect(few[c], truths[i][c], fmt::format("twin, channel {}", c));
        }
    }
}

/// A lit, coloured, forward scattering case of which nothing is known.
Case busy() {
    Case it = rough({0.95, 0.8, 0.5});
    it.options.view.light_direction = {1, 0.5f, -1};
    it.options.view.light_irradiance = glm::vec3(2.0f);
    it.options.view.environment = glm::vec3(0.2f);
    it.options.view.phase_g = 0.6f;
    it.samples = 32;
    return it;
}

TEST_F(PathTraceTest, LocalMajorantsModesAndLightSamplingDoNotChangeTheMean) {
    Case it = busy();
    it.samples = 256;
    const Result local = trace(it);
    it.options.view.seed = 2;
    it.global_majorant = true;
    const Result global = trace(it);
    it.options.view.seed = 3;
    it.global_majorant = false;
    it.params.mode = PathMode::noncaching;
    const Result noncaching = trace(it);
    const Family family(6);
    for (std::size_t c = 0; c < 3; ++c) {
        family.expect(local.mean[c], global.mean[c], "global majorant");
        family.expect(local.mean[c], noncaching.mean[c], "noncaching without a surface");
    }
    // Every cell holds something nearly as dense as the densest: no loss, if no gain.
    EXPECT_LT(double(local.statistics.steps), 1.01 * double(global.statistics.steps));
}

TEST_F(PathTraceTest, LocalMajorantsSaveStepsWhereMostIsEmpty) {
    Case it = busy();
    it.volume = float_volume(glm::uvec3(32),
        [](glm::uvec3 voxel) { return glm::length(glm::dvec3(voxel) - 15.5) < 5 ? 1.0 : 0.01; });
    const Result local = trace(it);
    it.options.view.seed = 2;
    it.global_majorant = true;
    const Result global = trace(it);
    Family(1).expect(local.mean[0], global.mean[0], "global majorant");
    EXPECT_LT(double(local.statistics.steps), 0.5 * double(global.statistics.steps));
}

TEST_F(PathTraceTest, SampledSkyAgreesWithTheSkyMetByChance) {
    Case it = busy();
    it.options.environment = Image(8, 4, {"R", "G", "B"});
    Pcg32 rng(3);
    for (int c = 0; c < 3; ++c)
        for (float& texel : it.options.environment.plane(c)) texel = std::pow(rng.uniform(), 4.0f);
    it.options.environment.at(5, 1, 0) = 20;
    for (const float irradiance : {0.0f, 2.0f}) { // the sun takes half of the light samples
        it.options.view.light_irradiance = glm::vec3(irradiance);
        it.samples = 128;
        it.options.view.seed = 1;
        it.params.nee = true;
        const Result sampled = trace(it);
        if (irradiance > 0) { // without light sampling the sun is never met
            it.options.view.environment = glm::vec3(0.0f);
            continue;
        }
        it.options.view.seed = 2;
        it.params.nee = false;
        it.samples = 512;
        const Result met = trace(it);
        for (std::size_t c = 0; c < 3; ++c) Family(3).expect(sampled.mean[c], met.mean[c], "sky");
    }
}

TEST_F(PathTraceTest, BudgetsChangeNoBit) {
    for (const std::uint32_t iterations : {64u, 7u}) {
        Case it = busy();
        const Result whole = trace(it);
        it.params.iterations = iterations;
        const Result pieces = trace(it);
        EXPECT_EQ(whole.sum, pieces.sum);
        EXPECT_EQ(whole.statistics.steps, pieces.statistics.steps);
        EXPECT_GT(pieces.statistics.resumed, 1000u);
        EXPECT_EQ(whole.statistics.resumed, 0u);
    }
}

TEST_F(PathTraceTest, FewSamplesHaveNoBias) {
    // Short paths finish first: a mean over what has finished would be too bright.
    Case it = cube(4, 0.8f);
    it.options.width = it.options.height = 512;
    it.samples = 2;
    it.params.iterations = 30;
    const Estimate mean = trace(it).mean[0];
    EXPECT_LE(z_of(mean, {0.5610, 1e-4}), z_limit(1)) << mean.mean << " +- " << mean.error;
}

TEST_F(PathTraceTest, SeedsDecideEveryBit) {
    Case it = busy();
    const Result once = trace(it), again = trace(it);
    EXPECT_EQ(once.sum, again.sum);
    it.options.view.seed = 2;
    const Result other = trace(it);
    for (std::size_t i = 0; i < once.sum.size(); i += 4) { // pixels that see much of the medium
        const bool much = once.sum[i + 3] > 16;
        EXPECT_TRUE(!much || once.sum[i] != other.sum[i]) << "pixel " << i / 4;
    }
}

TEST_F(PathTraceTest, NoiseOfPixelsIsIndependent) {
    Case it = cube(2, 0.5f);
    it.options.camera = flat_view({0, 0, 2}, 0.01f);
    it.options.width = it.options.height = 128;
    it.samples = 8;
    const Result result = trace(it);
    const double mean = 8 * result.mean[0].mean;
    const auto at = [&](int x, int y) {
        return result.sum[static_cast<std::size_t>(y * 128 + x) * 4] - mean;
    };
    double power = 0;
    for (int y = 0; y < 128; ++y)
        for (int x = 0; x < 128; ++x) power += at(x, y) * at(x, y);
    for (const auto& [dx, dy] :
        {std::pair{1, 0}, {0, 1}, {1, 1}, {8, 0}, {0, 8}, {2, 0}, {64, 0}}) {
        double product = 0;
        for (int y = 0; y < 128; ++y)
            for (int x = 0; x < 128; ++x) product += at(x, y) * at((x + dx) % 128, (y + dy) % 128);
        EXPECT_LT(std::abs(product / power), 4.0 / 128) << dx << ", " << dy;
    }
}

/// A ball of radius 0.4 of values from 1 in the middle to 0 at its edge, 24^3 voxels.
Volume ball() {
    return float_volume(glm::uvec3(24),
        [](glm::uvec3 v) { return 1 - glm::length((glm::dvec3(v) + 0.5) / 24.0 - 0.5) / 0.4; });
}

/// The ball as a white surface of Lambert at radius 0.2 in a thin medium.
Case solid(float opacity = 1) {
    Case it;
    it.volume = ball();
    it.transfer = linear_transfer();
    it.options.view.density_scale = 2;
    VolumeView::Surface surface{.value = 0.5, .opacity = opacity};
    surface.material.base_color = glm::vec3(1.0f);
    it.options.view.surfaces.push_back(surface);
    it.options.width = it.options.height = 32;
    it.samples = 32;
    return it;
}

TEST_F(PathTraceTest, WhiteSurfacesInWhiteMediumAreAFurnace) {
    for (const float opacity : {1.0f, 0.4f}) {
        const Result result = trace(solid(opacity));
        for (const Estimate& mean : result.mean)
            EXPECT_NEAR(mean.mean, 1, 1e-5) << "Lambert's sampling leaves no variance";
    }
}

TEST_F(PathTraceTest, SurfacesAreShadedLocallyUnlessTheyScatter) {
    // Seen along z, in vacuum: base colour times (cosine irradiance / pi + environment).
    Case it = solid();
    it.options.view.density_scale = 0;
    it.options.view.surfaces[0].material.base_color = glm::vec3(0.6f);
    it.options.view.environment = glm::vec3(0.5f);
    it.options.view.light_direction = {0, 0.6f, -0.8f};
    it.options.view.light_irradiance = glm::vec3(2.0f);
    it.options.camera = flat_view({0, 0, 2});
    it.params.mode = PathMode::noncaching;
    const Estimate local = trace(it).mean[0];
    EXPECT_NEAR(local.mean, 0.6 * (0.8 * 2 / kPi + 0.5), 2e-3);
    // The sun from below: the surface is in its own shadow.
    it.options.view.light_direction = {0, 0, 1};
    EXPECT_NEAR(trace(it).mean[0].mean, 0.6 * 0.5, 1e-5);
    // In the path mode a convex surface sees the same environment: its light does not come back,
    // but for what the normals, which are not the facets', send into it.
    it.params.mode = PathMode::path;
    it.samples = 256;
    const Family family(2);
    family.expect(trace(it).mean[0], {0.6 * 0.5, 3e-4}, "scattering surface");
    it.options.view.surface_gain = 3;
    it.options.view.seed = 2;
    family.expect(trace(it).mean[0], {3 * 0.6 * 0.5, 9e-4}, "its gain");
}

TEST_F(PathTraceTest, OpaqueSurfacesKeepTheirShadow) {
    // Behind the ball, seen across the sun's rays, single scattering: dark.
    Case it = solid();
    it.options.view.environment = glm::vec3(0.0f);
    it.options.view.light_direction = {0, 0, -1};
    it.options.view.light_irradiance = glm::vec3(1.0f);
    it.options.view.max_bounces = 1;
    it.volume = float_volume(glm::uvec3(24), [](glm::uvec3 v) {
        return 0.3 + 0.5 * (glm::length((glm::dvec3(v) + 0.5) / 24.0 - 0.5) < 0.25);
    });
    it.options.camera = flat_view({2, 0, -0.4f}, 0.1f);
    it.options.camera.position = {2, 0, -0.4f};
    it.options.camera.forward = {-1, 0, 0};
    it.options.width = it.options.height = 8;
    const Result middle = trace(it); // z = -0.4, |y| < 0.05: all of the umbra, and lit sides
    it.options.view.crop_min = {0.4f, 0.4f, 0.0f};
    it.options.view.crop_max = {0.6f, 0.6f, 1.0f};
    const Result umbra = trace(it); // only what lies behind the ball
    EXPECT_GT(middle.mean[0].mean, 0.0);
    EXPECT_GT(umbra.alpha, 0.01);
    EXPECT_EQ(umbra.mean[0].mean, 0.0);
}

TEST_F(PathTraceTest, CamerasMayStandAnywhere) {
    // Inside of the solid: the surface is met at once.
    Case it = solid();
    it.options.view.density_scale = 0;
    it.options.view.surfaces[0].material.base_color = glm::vec3(0.25f);
    it.params.mode = PathMode::noncaching;
    it.options.camera = look_at({0, 0, 0.05f}, {0, 0, 1}, 60);
    Result result = trace(it);
    EXPECT_EQ(result.alpha, 1.0);
    EXPECT_NEAR(result.mean[0].mean, 0.25, 1e-6);
    // On a face, along it, from a corner along an edge: finite, and a furnace stays one.
    for (const glm::vec3 position :
        {glm::vec3(0.5f, 0, 0), glm::vec3(0.5f), glm::vec3(0, 0, -0.5f)}) {
        for (const glm::vec3 forward :
            {glm::vec3(0, 0, 1), glm::vec3(-1, 0, 0), glm::vec3(0, -1, 0)}) {
            Case furnace = solid();
            furnace.options.view.surfaces.clear();
            furnace.options.camera = look_at(position, position + forward, 0.01f);
            furnace.options.width = furnace.options.height = 3;
            furnace.params.jitter = false; // the middle pixel is exactly parallel
            furnace.samples = 8;
            for (std::size_t i = 0; const float sum : trace(furnace).sum)
                EXPECT_EQ(i++ % 4 < 3 ? sum : 8, 8);
        }
    }
}

TEST_F(PathTraceTest, BudgetsChangeNoBitOfSurfaces) {
    Case it = solid(0.5f);
    it.options.view.light_direction = {0.5f, 0.7f, -1};
    it.options.view.light_irradiance = glm::vec3(2.0f);
    it.options.view.surfaces.push_back(VolumeView::Surface{.value = 0.2, .opacity = 0.3f});
    it.options.view.density_scale = 8;
    for (const PathMode mode : {PathMode::path, PathMode::noncaching}) {
        it.params.mode = mode;
        it.params.iterations = kPathIterations;
        const Result whole = trace(it);
        it.params.iterations = 50;
        const Result pieces = trace(it);
        EXPECT_EQ(whole.sum, pieces.sum);
        EXPECT_GT(pieces.statistics.resumed, 1000u);
    }
}

TEST_F(PathTraceTest, SpacingAndAxesAreTheBoxs) {
    // The same cube of fog: 16^3 voxels, 16 x 16 x 4 with four times the spacing, and turned.
    const auto make = [&](glm::uvec3 dims, glm::dvec3 spacing, int axis) {
        Case it = busy();
        it.volume = float_volume(
            dims, [&](glm::uvec3 v) { return static_cast<double>(v[axis]) / (dims[axis] - 1); });
        it.volume.spacing_mm = spacing;
        it.options.view.phase_g = 0.3f;
        it.samples = 128;
        return it;
    };
    const auto even = trace(make({16, 16, 16}, {1, 1, 1}, 0)).mean;
    Case coarse = make({16, 16, 4}, {1, 1, 4}, 0);
    coarse.options.view.seed = 2;
    const auto uneven = trace(coarse).mean;
    Case turned = make({16, 16, 16}, {1, 1, 1}, 0);
    turned.options.view.seed = 3;
    turned.volume.direction = {{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}; // about z
    const auto turn = [](glm::vec3 v) { return glm::vec3(-v.y, v.x, v.z); };
    turned.options.view.light_direction = turn(turned.options.view.light_direction);
    turned.options.camera.position = turn(turned.options.camera.position);
    turned.options.camera.forward = turn(turned.options.camera.forward);
    turned.options.camera.up = turn(turned.options.camera.up);
    const auto rotated = trace(turned).mean;
    const Family family(6);
    for (std::size_t c = 0; c < 3; ++c) {
        family.expect(uneven[c], even[c], "spacing");
        family.expect(rotated[c], even[c], "rotation");
    }
}

} // namespace
} // namespace ockham::test

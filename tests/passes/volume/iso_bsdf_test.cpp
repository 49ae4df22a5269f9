// SPDX-License-Identifier: Apache-2.0
// Reflection of isosurfaces (shaders/include/iso_bsdf.glsl): its formulas against a plain twin, its
// sampling against its densities, and that no material returns more light than it gets.
#include "framework/core/rng.hpp"
#include "framework/runtime/commands.hpp"
#include "shaders/shared/volume.h"
#include "tests/passes/volume/shaders/test/iso_bsdf.h"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/pass_bench.hpp"
#include "tests/support/z_test.hpp"

#include <array>
#include <cmath>
#include <numbers>

namespace ockham::test {
namespace {

using Answer = shader::IsoBsdfAnswer;
using Material = shader::IsoMaterial;
using std::numbers::pi;

/// As the kernel's: normal +z, x along the horizon.
glm::dmat3 frame_of(glm::dvec3 n) {
    const glm::dvec3 x = glm::normalize(glm::dvec3(n.z, 0, -n.x));
    return {x, glm::cross(n, x), n};
}
glm::dvec3 spherical(double cosine, double azimuth) {
    const double sine = std::sqrt(1 - cosine * cosine);
    return {sine * std::cos(azimuth), sine * std::sin(azimuth), cosine};
}

/// Cells around the mirror direction of a view, dense towards it, each with a direction at random,
/// for what ends abruptly at the horizon.
struct Directions {
    static constexpr std::size_t kRings = 384, kSectors = 192;
    glm::dmat3 around;
    std::vector<glm::dvec3> local;
    std::vector<double> weights; ///< solid angle for which each stands
    explicit Directions(glm::dvec3 view) : around(1.0) {
        const glm::dvec3 axis(-view.x, -view.y, view.z);
        const glm::dvec3 side =
            glm::normalize(std::abs(axis.z) < 0.9 ? glm::cross(axis, glm::dvec3(0, 0, 1))
                                                  : glm::cross(axis, glm::dvec3(1, 0, 0)));
        around = {side, glm::cross(axis, side), axis};
        Pcg32 rng(12);
        for (std::size_t ring = 0; ring < kRings; ++ring) {
            for (std::size_t sector = 0; sector < kSectors; ++sector) {
                const double u = (static_cast<double>(ring) + double{rng.uniform()}) / kRings;
                const double v = (static_cast<double>(sector) + double{rng.uniform()}) / kSectors;
                const double theta = pi * std::pow(u, 4.0), slope = 4 * pi * std::pow(u, 3.0);
                local.push_back(
                    around * glm::dvec3(std::sin(theta) * std::cos(2 * pi * v),
                                 std::sin(theta) * std::sin(2 * pi * v), std::cos(theta)));
                weights.push_back(std::sin(theta) * slope / kRings * 2 * pi / kSectors);
            }
        }
    }
    std::size_t cell_of(glm::dvec3 l) const {
        const glm::dvec3 p = l * around;
        const double theta = std::atan2(std::hypot(p.x, p.y), p.z);
        const double phi = std::atan2(p.y, p.x) / (2 * pi);
        const auto ring = static_cast<std::size_t>(kRings * std::pow(theta / pi, 0.25));
        const auto sector = static_cast<std::size_t>(kSectors * (phi < 0 ? phi + 1 : phi));
        return std::min(ring, kRings - 1) * kSectors + std::min(sector, kSectors - 1);
    }
};

/// Burley's formula as printed, without the clear coat: BRDF * cos, in the local frame.
glm::dvec3 burley(const Material& m, glm::dvec3 v, glm::dvec3 l) {
    const glm::dvec3 base(m.base_color), h = glm::normalize(v + l);
    const double roughness = double{m.roughness}, metallic = double{m.metallic};
    const auto f = [](double cosine) { return std::pow(1 - cosine, 5); };
    const double l_h = glm::dot(l, h), fl = f(l.z), fv = f(v.z), fh = f(l_h);
    const double luma = 0.3 * base.x + 0.6 * base.y + 0.1 * base.z;
    const glm::dvec3 tint = luma > 0 ? base / luma : glm::dvec3(1);
    const double fd90 = 0.5 + 2 * l_h * l_h * roughness;
    const double diffuse = (1 + (fd90 - 1) * fl) * (1 + (fd90 - 1) * fv);
    const double ss90 = l_h * l_h * roughness;
    const double ss =
        1.25 * ((1 + (ss90 - 1) * fl) * (1 + (ss90 - 1) * fv) * (1 / (l.z + v.z) - 0.5) + 0.5);
    const glm::dvec3 sheen =
        fh * double{m.sheen} * glm::mix(glm::dvec3(1), tint, double{m.sheen_tint});
    const glm::dvec3 body =
        (glm::mix(diffuse, ss, double{m.subsurface}) / pi * base + sheen) * (1 - metallic);

    const double aspect = std::sqrt(1 - 0.9 * double{m.anisotropic});
    const double ax = std::max(0.001, roughness * roughness / aspect);
    const double ay = std::max(0.001, roughness * roughness * aspect);
    const double q = h.x * h.x / (ax * ax) + h.y * h.y / (ay * ay) + h.z * h.z;
    const double d = 1 / (pi * ax * ay * q * q);
    const auto g = [&](glm::dvec3 w) {
        return 1 / (w.z + std::sqrt(ax * ax * w.x * w.x + ay * ay * w.y * w.y + w.z * w.z));
    };
    const glm::dvec3 dielectric =
        0.08 * double{m.specular} * glm::mix(glm::dvec3(1), tint, double{m.specular_tint});
    const glm::dvec3 reflectance = glm::mix(dielectric, base, metallic);
    return (body + glm::mix(reflectance, glm::dvec3(1), fh) * (g(v) * g(l) * d)) * l.z;
}
/// Its clear coat alone.
double burley_coat(const Material& m, glm::dvec3 v, glm::dvec3 l) {
    const glm::dvec3 h = glm::normalize(v + l);
    const double alpha = 0.1 + (0.001 - 0.1) * double{m.clearcoat_gloss}, a = alpha * alpha;
    const double d = (a - 1) / (pi * std::log(a) * (1 + (a - 1) * h.z * h.z));
    const auto g = [](double z) { return 1 / (z + std::sqrt(0.0625 + z * z - 0.0625 * z * z)); };
    const double f = 0.04 + 0.96 * std::pow(1 - glm::dot(l, h), 5);
    return 0.25 * double{m.clearcoat} * d * f * g(v.z) * g(l.z) * l.z;
}

class IsoBsdfTest : public GpuTest {
protected:
    struct Case {
        Material material;
        std::uint32_t shading;
        glm::dvec3 view; ///< local
    };
    static inline const glm::dvec3 kNormal = glm::normalize(glm::dvec3(0.3, -0.5, 0.8));

    static std::vector<Answer> run(
        const Case& at, std::uint32_t mode, const std::vector<glm::vec3>& given, std::size_t n) {
        PassBench bench(device());
        const BufferHandle materials = bench.buffer("materials", std::vector{at.material});
        const BufferHandle directions = bench.buffer("directions", given);
        BufferHandle out = bench.graph.create_buffer("answers", {n * sizeof(Answer)});
        PassBuilder pass = bench.graph.add_compute_pass("iso_bsdf");
        pass.read("materials", materials).read("directions", directions);
        out = pass.write("answers", out);
        bench.graph.export_resource(out, "test");
        const auto count = static_cast<std::uint32_t>(n);
        const shader::IsoBsdfPush push{.normal = kNormal,
            .view = frame_of(kNormal) * at.view,
            .shading = at.shading,
            .material = 0,
            .mode = mode,
            .count = count};
        pass.record([push](Commands& commands) {
            commands.dispatch_over(
                {.shader = "test/iso_bsdf.comp", .push = as_push(push)}, {push.count, 1, 1});
        });
        bench.execute();
        return bench.read<Answer>(out);
    }
    static std::vector<Answer> evaluate(const Case& at, const std::vector<glm::dvec3>& local) {
        std::vector<glm::vec3> directions;
        for (const glm::dvec3& l : local) directions.emplace_back(frame_of(kNormal) * l);
        return run(at, 0, directions, local.size());
    }
    static std::vector<Answer> sample(const Case& at, std::size_t count) {
        return run(at, 1, {glm::vec3(0.0f)}, count);
    }
    struct Integrals {
        glm::dvec3 albedo{0.0};
        double pdf = 0;            ///< above the horizon
        std::vector<double> cells; ///< of that
    };
    static Integrals integrate(const Case& at) {
        const Directions grid(at.view);
        const std::vector<Answer> answers = evaluate(at, grid.local);
        Integrals out;
        for (std::size_t i = 0; i < answers.size(); ++i) {
            const double share = grid.weights[i];
            out.albedo += glm::dvec3(answers[i].value) * share;
            out.cells.push_back(grid.local[i].z > 0 ? double{answers[i].pdf} * share : 0.0);
            out.pdf += out.cells.back();
        }
        return out;
    }

    static Material material(double base, double metallic, double roughness) {
        Material m{};
        m.base_color = glm::vec3(static_cast<float>(base));
        m.metallic = static_cast<float>(metallic);
        m.specular = 0.5f;
        m.roughness = static_cast<float>(roughness);
        return m;
    }
    /// Extremes of all parameters, at random.
    static std::vector<Case> extremes(std::size_t count) {
        Pcg32 rng(4);
        std::vector<Case> cases;
        const auto pick = [&](std::initializer_list<float> values) {
            return values.begin()[rng.below(static_cast<std::uint32_t>(values.size()))];
        };
        const std::array<glm::vec3, 4> colors{
            glm::vec3(1), glm::vec3(0, 0, 1), glm::vec3(1, 0.8f, 0.1f), glm::vec3(0)};
        while (cases.size() < count) {
            const Material m{.base_color = colors[rng.below(4)],
                .metallic = pick({0, 0, 0.5f, 1}),
                .subsurface = pick({0, 0.5f, 1}),
                .specular = pick({0, 0.5f, 1}),
                .roughness = pick({0.1f, 0.3f, 0.6f, 1}),
                .specular_tint = pick({0, 1}),
                .anisotropic = pick({0, 0.5f, 1}),
                .sheen = pick({0, 1}),
                .sheen_tint = pick({0, 1}),
                .clearcoat = pick({0, 1}),
                .clearcoat_gloss = pick({0, 0.5f, 1})};
            const double cosine = double{pick({0.03f, 0.1f, 0.3f, 0.6f, 0.95f})};
            cases.push_back({m, SHADING_DISNEY, spherical(cosine, double{rng.uniform(0, 6.28f)})});
        }
        return cases;
    }
    static std::vector<Case> simple() {
        std::vector<Case> cases;
        for (const double cosine : {1.0, 0.5, 0.1}) {
            cases.push_back({material(0.7, 0, 0.5), SHADING_LAMBERT, spherical(cosine, 1)});
            Material shiny = material(1, 0, 0.2);
            shiny.specular = 1;
            cases.push_back({shiny, SHADING_PHONG, spherical(cosine, 2)});
            cases.push_back({material(0.5, 0, 0.7), SHADING_PHONG, spherical(cosine, 3)});
        }
        return cases;
    }
    static std::vector<Case> all(std::size_t extreme) {
        std::vector<Case> cases = simple(), more = extremes(extreme);
        cases.insert(cases.end(), more.begin(), more.end());
        return cases;
    }
};

TEST_F(IsoBsdfTest, DisneyIsBurleysFormulaWhereNothingIsClamped) {
    Pcg32 rng(1);
    for (int i = 0; i < 12; ++i) {
        Material m{.base_color = {rng.uniform(0.1f, 0.5f), rng.uniform(0.1f, 0.5f), 0.3f},
            .metallic = rng.uniform(0, 0.6f),
            .subsurface = rng.uniform(),
            .specular = rng.uniform(),
            .roughness = rng.uniform(0.3f, 1),
            .specular_tint = rng.uniform(),
            .anisotropic = rng.uniform(),
            .sheen = rng.uniform(0, 0.3f),
            .sheen_tint = rng.uniform(),
            .clearcoat = 0,
            .clearcoat_gloss = rng.uniform()};
        const Case bare{
            m, SHADING_DISNEY, spherical(double{rng.uniform(0.4f, 1)}, double{rng.uniform(0, 6)})};
        m.clearcoat = 1;
        const Case coated{m, SHADING_DISNEY, bare.view};
        std::vector<glm::dvec3> local;
        for (int k = 0; k < 200; ++k)
            local.push_back(spherical(double{rng.uniform(0.4f, 1)}, double{rng.uniform(0, 6.28f)}));
        const std::vector<Answer> answers = evaluate(bare, local), coats = evaluate(coated, local);
        for (std::size_t k = 0; k < local.size(); ++k) {
            const glm::dvec3 expected = burley(bare.material, bare.view, local[k]);
            const double coat = burley_coat(m, bare.view, local[k]);
            for (int c = 0; c < 3; ++c) {
                EXPECT_NEAR(double{answers[k].value[c]}, expected[c], 1e-4 * (expected[c] + 0.1));
                // The coat lets at least 95 % through to what lies under it, and back.
                EXPECT_LE(double{coats[k].value[c]}, 1.001 * (coat + expected[c]));
                EXPECT_GE(double{coats[k].value[c]}, 0.999 * (coat + 0.95 * expected[c]));
            }
        }
    }
}

TEST_F(IsoBsdfTest, ClosedForms) {
    const Case lambert{material(0.7, 1, 0.1), SHADING_LAMBERT, spherical(0.3, 0)};
    EXPECT_NEAR(integrate(lambert).albedo.x, 0.7, 1e-3);
    Material m = material(0.25, 0, 0.4);
    m.specular = 1;
    const Case phong{m, SHADING_PHONG, {0, 0, 1}};
    EXPECT_NEAR(integrate(phong).albedo.y, 0.92 * 0.25 + 0.08, 1e-3) << "seen head on";
    const double exponent = 0.5 / std::pow(0.4, 4) - 0.5;
    const Answer peak = evaluate(phong, {{0, 0, 1}})[0];
    EXPECT_NEAR(double{peak.value.x}, 0.92 * 0.25 / pi + 0.08 * (exponent + 2) / (2 * pi), 1e-4);
    for (const std::uint32_t shading : {SHADING_LAMBERT, SHADING_PHONG, SHADING_DISNEY}) {
        for (const Answer& a : evaluate({m, shading, spherical(0.5, 0)}, {{0, 0.6, -0.8}}))
            EXPECT_EQ(a.value, glm::vec3(0)) << "below the horizon";
        const std::vector<Answer> grazing =
            evaluate({m, shading, spherical(0, 0)}, {{0, 0, 1}, {0, 1, 1e-6}, {-1, 0, 1e-6}});
        for (const Answer& a : grazing) {
            EXPECT_TRUE(std::isfinite(a.value.x) && a.value.x >= 0);
            EXPECT_TRUE(std::isfinite(a.pdf) && a.pdf >= 0);
        }
    }
}

TEST_F(IsoBsdfTest, ARoughPhongIsEvenUpToNinetyDegreesFromTheMirrorDirection) {
    Material m = material(0.5, 0, 1); // exponent 0
    m.specular = 1;
    const glm::dvec3 view = spherical(0.2, 0), mirror(-view.x, -view.y, view.z);
    const glm::dvec3 near = spherical(0.5, pi), far = spherical(0.5, 0);
    ASSERT_LT(glm::dot(far, mirror), 0);
    const std::vector<Answer> answers = evaluate({m, SHADING_PHONG, view}, {mirror, near, far});
    for (int i = 0; i < 3; ++i) {
        const double cosine = i == 0 ? 0.2 : 0.5, lobe = i < 2 ? 0.08 : 0;
        const Answer& a = answers[static_cast<std::size_t>(i)];
        EXPECT_NEAR(double{a.value.x}, (0.92 * 0.5 + lobe) / pi * cosine, 1e-6) << i;
        EXPECT_NEAR(double{a.pdf}, 0.92 * cosine / pi + lobe / (2 * pi), 1e-6) << i;
    }
}

TEST_F(IsoBsdfTest, DensitiesIntegrateToOneAndAlbedosStayBelowIt) {
    const std::vector<Case> cases = all(60);
    const double limit = z_limit(cases.size());
    for (const Case& at : cases) {
        const Material& m = at.material;
        SCOPED_TRACE(testing::Message()
                     << "shading " << at.shading << ", cos " << at.view.z << ", base "
                     << m.base_color.x << " " << m.base_color.z << ", metallic " << m.metallic
                     << ", subsurface " << m.subsurface << ", specular " << m.specular
                     << ", roughness " << m.roughness << ", anisotropic " << m.anisotropic
                     << ", sheen " << m.sheen << ", clearcoat " << m.clearcoat << " "
                     << m.clearcoat_gloss);
        const Integrals integrals = integrate(at);
        // Below the horizon densities are too wild for a grid; the share of samples there is not.
        double above = 0;
        const std::vector<Answer> samples = sample(at, 16384);
        for (const Answer& a : samples) above += glm::dot(a.direction, glm::vec3(kNormal)) > 0;
        const auto n = static_cast<double>(samples.size());
        const double error = std::sqrt(std::max(above * (n - above), 1.0) / n) / n;
        EXPECT_LT(z_of({above / n, error}, {integrals.pdf, 5e-4}), limit);
        for (int c = 0; c < 3; ++c) EXPECT_LE(integrals.albedo[c], 1 + 1e-3) << "channel " << c;
    }
}

TEST_F(IsoBsdfTest, SamplesHaveTheirWeightsDensitiesAndDistribution) {
    const std::vector<Case> cases = all(24);
    const double limit = z_limit(cases.size() * 2);
    for (const Case& at : cases) {
        SCOPED_TRACE(testing::Message()
                     << "shading " << at.shading << ", cos " << at.view.z << ", roughness "
                     << at.material.roughness << ", clearcoat " << at.material.clearcoat << " "
                     << at.material.clearcoat_gloss << ", anisotropic " << at.material.anisotropic);
        const Integrals integrals = integrate(at);
        const std::vector<Answer> samples = sample(at, 65536);
        const Directions grid(at.view);
        double sum = 0, square = 0, below = 0;
        constexpr std::size_t kMerge = 24; // cells along each axis to a bin
        constexpr std::size_t kWide = Directions::kSectors / kMerge;
        std::vector<double> counts(Directions::kRings / kMerge * kWide, 0.0);
        std::vector<double> expected(counts.size(), 0.0);
        const auto bin_of = [](std::size_t cell) {
            return cell / Directions::kSectors / kMerge * kWide +
                   cell % Directions::kSectors / kMerge;
        };
        for (const Answer& a : samples) {
            ASSERT_TRUE(std::isfinite(a.value.x) && a.pdf >= 0);
            ASSERT_NEAR(glm::length(a.direction), 1.0f, 1e-4f);
            const float cosine = glm::dot(a.direction, glm::vec3(kNormal));
            if (cosine > 1e-4f) { // rounding the normal's frame shifts l by 1e-7
                ASSERT_NEAR(a.pdf_again / a.pdf, 1.0f, 0.02f) << "pdf " << a.pdf;
                ASSERT_NEAR(a.value.x * a.pdf, a.again.x, 0.02f * a.again.x + 1e-5f);
            } else if (cosine < -1e-4f) {
                ASSERT_EQ(a.value, glm::vec3(0));
            }
            sum += double{a.value.x};
            square += double{a.value.x} * double{a.value.x};
            const std::size_t bin =
                bin_of(grid.cell_of(glm::dvec3(a.direction) * frame_of(kNormal)));
            (cosine > 0 ? counts[bin] : below) += 1;
        }
        const auto n = static_cast<double>(samples.size());
        const double mean = sum / n, error = std::sqrt(std::max(square / n - mean * mean, 0.0) / n);
        // 5e-4: the quadrature's own error.
        EXPECT_LT(z_of({mean, error}, {integrals.albedo.x, 5e-4}), limit);

        for (std::size_t i = 0; i < integrals.cells.size(); ++i)
            expected[bin_of(i)] += n * integrals.cells[i];
        double chi2 = 0, rest_counts = below, rest_expected = n * (1 - integrals.pdf);
        int bins = 0;
        for (std::size_t i = 0; i < counts.size(); ++i) {
            if (expected[i] < 20) {
                rest_counts += counts[i];
                rest_expected += expected[i];
                continue;
            }
            chi2 += std::pow(counts[i] - expected[i], 2) / expected[i];
            ++bins;
        }
        if (rest_expected > 5) {
            chi2 += std::pow(rest_counts - rest_expected, 2) / rest_expected;
            ++bins;
        }
        const double dof = bins - 1, spread = 2 / (9 * dof); // Wilson and Hilferty 1931
        const double z = (std::cbrt(chi2 / dof) - (1 - spread)) / std::sqrt(spread);
        EXPECT_LT(z, limit) << chi2 << " of " << bins << " bins";
    }
}

TEST_F(IsoBsdfTest, LightMayGoEitherWay) {
    Pcg32 rng(9);
    for (const Case& at : all(30)) {
        std::vector<glm::dvec3> local;
        for (int k = 0; k < 300; ++k)
            local.push_back(
                spherical(double{rng.uniform(0.02f, 1)}, double{rng.uniform(0, 6.28f)}));
        const std::vector<Answer> answers = evaluate(at, local);
        for (std::size_t k = 0; k < local.size(); ++k) {
            const double there = double{answers[k].value.x} / local[k].z;
            const double back = double{answers[k].again.x} / at.view.z;
            ASSERT_NEAR(there, back, 2e-3 * there + 1e-6) << "shading " << at.shading;
        }
    }
}

} // namespace
} // namespace ockham::test

// SPDX-License-Identifier: Apache-2.0
// shaders/include/phase.glsl
#include "framework/core/rng.hpp"
#include "framework/runtime/commands.hpp"
#include "tests/support/chi_squared.hpp"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/pass_bench.hpp"
#include "tests/support/z_test.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ockham {
namespace {

constexpr float kAnisotropies[] = {-0.99f, -0.6f, -1e-4f, 0.0f, 0.3f, 0.6f, 0.99f};

struct Push {
    glm::vec3 forward;
    float g;
};

class PhaseTest : public test::GpuTest {
protected:
    /// xyz: sample_phase() of a query's x and y; w: phase() of its z.
    static std::vector<glm::vec4> ask(const Push& push, const std::vector<glm::vec3>& queries) {
        test::PassBench bench(device());
        const BufferHandle input = bench.buffer("queries", queries);
        PassBuilder pass = bench.graph.add_compute_pass("phase");
        pass.read("queries", input);
        const BufferHandle answers = pass.write(
            "answers", bench.graph.create_buffer("answers", {queries.size() * sizeof(glm::vec4)}));
        pass.record([=, count = static_cast<std::uint32_t>(queries.size())](Commands& commands) {
            commands.dispatch_over(
                {.shader = "test/phase.comp", .specialization = {}, .push = as_push(push)},
                {count, 1, 1});
        });
        bench.graph.export_resource(answers, "tested");
        bench.execute();
        return bench.read<glm::vec4>(answers);
    }
};

double exact_phase(double g, double cosine) {
    return (1 - g * g) / (4 * std::numbers::pi * std::pow(1 + g * g - 2 * g * cosine, 1.5));
}

/// Probability of a cosine of at most this.
double cumulative(double g, double cosine) {
    if (g == 0) return (1 + cosine) / 2;
    return (1 - g * g) / (2 * g) * (1 / std::sqrt(1 + g * g - 2 * g * cosine) - 1 / (1 + g));
}

double cosine_between(glm::vec3 a, glm::vec3 b) { return glm::dot(glm::dvec3(a), glm::dvec3(b)); }

TEST_F(PhaseTest, IsHenyeyAndGreensteins) {
    std::vector<glm::vec3> queries;
    for (int i = 0; i <= 2000; ++i) {
        const double t = 2 * std::pow(i / 2000.0, 4); // dense in the peak, whichever side it is on
        queries.emplace_back(0.5f, 0.5f, static_cast<float>(1 - t));
        queries.emplace_back(0.5f, 0.5f, static_cast<float>(t - 1));
    }
    std::sort(queries.begin(), queries.end(), [](auto a, auto b) { return a.z < b.z; });
    for (const float g : kAnisotropies) {
        const std::vector<glm::vec4> answers = ask({{0, 0, 1}, g}, queries);
        double integral = 0;
        for (std::size_t i = 0; i < queries.size(); ++i) {
            const double exact = exact_phase(double{g}, double{queries[i].z});
            ASSERT_NEAR(double{answers[i].w} / exact, 1, 4e-6) << g << " at " << queries[i].z;
            if (i > 0)
                integral += std::numbers::pi * (double{answers[i].w} + double{answers[i - 1].w}) *
                            (double{queries[i].z} - double{queries[i - 1].z});
        }
        EXPECT_NEAR(integral, 1, 1e-3) << g;
    }
}

TEST_F(PhaseTest, MeanCosineIsG) {
    constexpr int kCount = 1 << 16; // evenly spaced numbers: a quadrature, not an experiment
    std::vector<glm::vec3> queries;
    for (int i = 0; i < kCount; ++i) {
        const float even = (static_cast<float>(i) + 0.5f) / kCount;
        queries.emplace_back(even, std::fmod(even * 377.0f, 1.0f), 0.0f);
    }
    for (const float g : kAnisotropies) {
        const glm::vec3 forward = glm::normalize(glm::vec3(0.3f, -0.8f, -0.5f));
        double mean = 0;
        for (const glm::vec4& answer : ask({forward, g}, queries)) {
            const glm::vec3 direction(answer);
            ASSERT_NEAR(glm::length(direction), 1.0f, 1e-6f);
            mean += cosine_between(forward, direction) / kCount;
        }
        EXPECT_NEAR(mean, double{g}, 1e-4);
    }
}

TEST_F(PhaseTest, SamplesAreDistributedByIt) {
    constexpr std::size_t kBins = 64, kCount = 1 << 17;
    Pcg32 rng(5);
    std::vector<glm::vec3> queries;
    for (std::size_t i = 0; i < kCount; ++i)
        queries.emplace_back(rng.uniform() + 0x1p-25f, rng.uniform() + 0x1p-25f, 0.0f);
    const std::vector<double> expected(kBins, double{kCount} / kBins);
    // Poles, and the other side of the seam of the basis.
    const glm::vec3 forwards[] = {{0, 0, 1}, {0, 0, -1}, glm::normalize(glm::vec3(1, 2, -1e-6f))};
    const double limit = test::z_limit(2 * std::size(forwards) * std::size(kAnisotropies));
    for (const float g : kAnisotropies) {
        for (const glm::vec3& forward : forwards) {
            const glm::vec3 aside =
                glm::normalize(glm::cross(forward, glm::vec3(0.6f, 0.48f, 0.64f)));
            const glm::vec3 above = glm::cross(forward, aside);
            std::vector<std::uint64_t> cosines(kBins), azimuths(kBins);
            for (const glm::vec4& answer : ask({forward, g}, queries)) {
                const glm::vec3 direction(answer);
                const double c = std::clamp(cosine_between(forward, direction), -1.0, 1.0);
                const double turn =
                    std::atan2(cosine_between(above, direction), cosine_between(aside, direction)) /
                        (2 * std::numbers::pi) +
                    0.5;
                const auto bin = [](double share) {
                    return std::min(static_cast<std::size_t>(share * kBins), kBins - 1);
                };
                ++cosines[bin(cumulative(double{g}, c))];
                ++azimuths[bin(turn)];
            }
            EXPECT_LT(test::chi_squared_z(cosines, expected), limit) << g;
            EXPECT_LT(test::chi_squared_z(azimuths, expected), limit) << g;
        }
    }
}

} // namespace
} // namespace ockham

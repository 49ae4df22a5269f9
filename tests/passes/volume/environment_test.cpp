// SPDX-License-Identifier: Apache-2.0
// shaders/volume/environment.glsl, and the tables that scene_gpu makes for it.
#include "framework/core/rng.hpp"
#include "framework/runtime/commands.hpp"
#include "tests/support/chi_squared.hpp"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/volume_bench.hpp"
#include "tests/support/z_test.hpp"

#include <cmath>
#include <functional>
#include <numbers>

namespace ockham {
namespace {

constexpr double kPi = std::numbers::pi;

struct Query {
    glm::vec2 xi;
    glm::vec3 direction;
};
struct Answer {
    glm::vec3 seen;
    float seen_pdf;
    glm::vec3 drawn, direction;
    float pdf, pdf_again;
};

Image make_map(int width, int height, const std::function<glm::vec3(int x, int y)>& texel) {
    Image map(width, height, {"R", "G", "B"});
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int c = 0; c < 3; ++c) map.at(x, y, c) = texel(x, y)[c];
    return map;
}

/// Dim texels, black ones, and a sun.
Image random_map(int width, int height) {
    Pcg32 rng(11);
    return make_map(width, height, [&](int x, int y) {
        if (x == width / 3 && y == height / 4) return glm::vec3(900, 800, 500);
        if (rng.below(4) == 0) return glm::vec3(0);
        return glm::vec3(rng.uniform(), rng.uniform(), rng.uniform());
    });
}

double luminance(const Image& map, int x, int y) {
    return 0.2126 * double{map.at(x, y, 0)} + 0.7152 * double{map.at(x, y, 1)} +
           0.0722 * double{map.at(x, y, 2)};
}

double solid_angle(const Image& map, int y) {
    return 2 * kPi / map.width() *
           (std::cos(kPi * y / map.height()) - std::cos(kPi * (y + 1) / map.height()));
}

glm::vec3 towards(const Image& map, double x, double y) {
    const double polar = kPi * y / map.height(), azimuth = 2 * kPi * (x / map.width() - 0.5);
    return {
        std::sin(polar) * std::sin(azimuth), std::sin(polar) * std::cos(azimuth), std::cos(polar)};
}

/// Where a direction lies on the map, in texels.
glm::dvec2 place_on(const Image& map, glm::vec3 direction) {
    const glm::dvec3 d(direction);
    return {map.width() * (0.5 + std::atan2(d.x, d.y) / (2 * kPi)),
        map.height() * std::acos(std::clamp(d.z, -1.0, 1.0)) / kPi};
}

std::vector<Query> random_queries(std::size_t count) {
    Pcg32 rng(13);
    std::vector<Query> queries;
    for (std::size_t i = 0; i < count; ++i) {
        const glm::vec2 xi(rng.uniform() + 0x1p-25f, rng.uniform() + 0x1p-25f);
        const glm::vec3 direction(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
        queries.push_back({xi, glm::normalize(direction)});
    }
    return queries;
}

class EnvironmentTest : public test::GpuTest {
protected:
    static std::vector<Answer> ask(const Image& map, const std::vector<Query>& queries) {
        const Volume volume = test::float_volume({2, 2, 2}, [](glm::uvec3) { return 1; });
        test::VolumeBench bench(device(), volume, test::linear_transfer(), {.environment = map});
        mean_ = bench.frame.environment;
        const BufferHandle input = bench.buffer("queries", queries);
        PassBuilder pass = bench.graph.add_compute_pass("environment");
        read_medium(pass, bench.inputs, {.tracking = false, .surfaces = false});
        pass.read("queries", input);
        const BufferHandle answers = pass.write(
            "answers", bench.graph.create_buffer("answers", {queries.size() * sizeof(Answer)}));
        pass.record([count = static_cast<std::uint32_t>(queries.size())](Commands& commands) {
            commands.dispatch_over(
                {.shader = "test/environment.comp:environment_map"}, {count, 1, 1});
        });
        bench.graph.export_resource(answers, "tested");
        bench.execute();
        return bench.read<Answer>(answers);
    }
    static inline glm::vec3 mean_; ///< frame.environment of the last question
};

TEST_F(EnvironmentTest, TexelsStandWhereTheyShould) {
    const Image map = random_map(20, 11);
    std::vector<Query> queries;
    for (int y = 0; y < 11; ++y)
        for (int x = 0; x < 20; ++x)
            queries.push_back({glm::vec2(0.5f), towards(map, x + 0.5, y + 0.5)});
    queries.push_back({glm::vec2(0.5f), {0, 0, 1}});       // row 0
    queries.push_back({glm::vec2(0.5f), {0, 0, -1}});      // last row
    queries.push_back({glm::vec2(0.5f), {0.01f, 1, 0}});   // right of the middle
    queries.push_back({glm::vec2(0.5f), {-0.01f, -1, 0}}); // first column
    const std::vector<Answer> answers = ask(map, queries);
    const auto texel = [&](int x, int y) {
        return glm::vec3(map.at(x, y, 0), map.at(x, y, 1), map.at(x, y, 2));
    };
    for (int y = 0; y < 11; ++y)
        for (int x = 0; x < 20; ++x)
            ASSERT_EQ(answers[static_cast<std::size_t>(20 * y + x)].seen, texel(x, y));
    const auto row_has = [&](int y, glm::vec3 seen) {
        for (int x = 0; x < 20; ++x)
            if (texel(x, y) == seen) return true;
        return false;
    };
    EXPECT_TRUE(row_has(0, answers[220].seen));
    EXPECT_TRUE(row_has(10, answers[221].seen));
    EXPECT_EQ(answers[222].seen, texel(10, 5));
    EXPECT_EQ(answers[223].seen, texel(0, 5));
}

TEST_F(EnvironmentTest, DensityIsLuminanceAndIntegratesToOne) {
    for (const glm::ivec2 size : {glm::ivec2(1, 1), glm::ivec2(33, 7), glm::ivec2(128, 64)}) {
        const Image map = random_map(size.x, size.y);
        std::vector<Query> queries;
        double total = 0;
        for (int y = 0; y < size.y; ++y) {
            for (int x = 0; x < size.x; ++x) {
                queries.push_back({glm::vec2(0.5f), towards(map, x + 0.5, y + 0.5)});
                total += luminance(map, x, y) * solid_angle(map, y);
            }
        }
        const std::vector<Answer> answers = ask(map, queries);
        double integral = 0;
        for (int y = 0; y < size.y; ++y) {
            for (int x = 0; x < size.x; ++x) {
                const double pdf =
                    double{answers[static_cast<std::size_t>(size.x * y + x)].seen_pdf};
                integral += pdf * solid_angle(map, y);
                ASSERT_NEAR(pdf, luminance(map, x, y) / total, 1e-6 * pdf);
            }
        }
        EXPECT_NEAR(integral, 1, 1e-5);
    }
}

TEST_F(EnvironmentTest, SamplesAreDistributedByTheDensity) {
    constexpr std::size_t kCount = 1 << 19;
    const double limit = test::z_limit(6);
    for (const glm::ivec2 size : {glm::ivec2(3, 2), glm::ivec2(33, 7), glm::ivec2(64, 33)}) {
        const Image map = random_map(size.x, size.y);
        const std::vector<Answer> answers = ask(map, random_queries(kCount));
        const auto texels = static_cast<std::size_t>(size.x * size.y);
        std::vector<std::uint64_t> counts(texels), within(256);
        std::vector<double> expected(texels);
        double total = 0;
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x)
                total += expected[static_cast<std::size_t>(y * size.x + x)] =
                    luminance(map, x, y) * solid_angle(map, y);
        for (double& share : expected) share *= kCount / total;
        std::size_t on_borders = 0;
        for (const Answer& answer : answers) {
            ASSERT_NEAR(glm::length(answer.direction), 1.0f, 1e-6f);
            const glm::dvec2 place = place_on(map, answer.direction);
            const glm::dvec2 texel = glm::min(glm::floor(place), glm::dvec2(size - 1));
            ++counts[static_cast<std::size_t>(texel.y) * static_cast<std::size_t>(size.x) +
                     static_cast<std::size_t>(texel.x)];
            // Inside a texel: even in azimuth and in the cosine.
            const double top = std::cos(kPi * texel.y / size.y);
            const double bottom = std::cos(kPi * (texel.y + 1) / size.y);
            const glm::dvec2 fraction = glm::clamp(
                glm::dvec2(place.x - texel.x, (top - double{answer.direction.z}) / (top - bottom)),
                0.0, 0.9999);
            ++within[static_cast<std::size_t>(fraction.y * 16) * 16 +
                     static_cast<std::size_t>(fraction.x * 16)];
            // The same density when asked for, but where rounding crosses a texel's border.
            const glm::dvec2 from_border = glm::abs(place - glm::round(place));
            if (std::min(from_border.x, from_border.y) < 1e-3) {
                ++on_borders;
                continue;
            }
            ASSERT_FLOAT_EQ(answer.pdf, answer.pdf_again);
        }
        EXPECT_LT(on_borders, kCount / 100);
        EXPECT_LT(test::chi_squared_z(counts, expected), limit);
        EXPECT_LT(test::chi_squared_z(within, std::vector<double>(256, kCount / 256.0)), limit);
    }
}

TEST_F(EnvironmentTest, EstimatesOfLuminanceHaveNoVariance) {
    const Image map = random_map(64, 32);
    double total = 0;
    glm::dvec3 mean(0);
    for (int y = 0; y < 32; ++y) {
        for (int x = 0; x < 64; ++x) {
            total += luminance(map, x, y) * solid_angle(map, y);
            mean += glm::dvec3(map.at(x, y, 0), map.at(x, y, 1), map.at(x, y, 2)) *
                    solid_angle(map, y) / (4 * kPi);
        }
    }
    for (const Answer& answer : ask(map, random_queries(10'000))) {
        const double estimate =
            glm::dot(glm::dvec3(answer.drawn), glm::dvec3(0.2126, 0.7152, 0.0722)) /
            double{answer.pdf};
        ASSERT_NEAR(estimate / total, 1, 1e-6);
    }
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(double{mean_[c]} / mean[c], 1, 1e-6);
}

TEST_F(EnvironmentTest, AConstantMapIsItsColour) {
    const glm::vec3 color(0.25f, 0.5f, 2.0f);
    for (const Answer& answer :
        ask(make_map(24, 12, [&](int, int) { return color; }), random_queries(10'000))) {
        ASSERT_EQ(answer.seen, color);
        ASSERT_EQ(answer.drawn, color);
        ASSERT_NEAR(answer.pdf, 1 / (4 * kPi), 1e-6);
        ASSERT_NEAR(answer.seen_pdf, 1 / (4 * kPi), 1e-6);
    }
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(mean_[c], color[c], 1e-6f);
}

TEST_F(EnvironmentTest, ABlackMapGivesNothingEvenly) {
    for (const Answer& answer :
        ask(make_map(8, 4, [](int, int) { return glm::vec3(0); }), random_queries(1000))) {
        ASSERT_EQ(answer.drawn, glm::vec3(0));
        ASSERT_GT(answer.pdf, 0.0f);
        ASSERT_NEAR(glm::length(answer.direction), 1.0f, 1e-6f);
    }
}

TEST_F(EnvironmentTest, WhatIsNoRadianceIsRefused) {
    Image map = random_map(4, 2);
    map.at(3, 1, 2) = -1.0f;
    EXPECT_EQ(test::error_of([&] { ask(map, random_queries(1)); }),
        "environment map: channel B of texel (3, 1) is -1; radiance is finite and not negative");
    EXPECT_EQ(test::error_of([&] {
        ask(Image(2, 2, {"R", "G", "Y"}), random_queries(1));
    }),
        "environment map: it has no channel B; expected R, G and B");
}

} // namespace
} // namespace ockham

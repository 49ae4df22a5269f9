// SPDX-License-Identifier: Apache-2.0
// shaders/include/random.glsl
#include "framework/core/rng.hpp"
#include "framework/runtime/commands.hpp"
#include "shaders/include/random.h"
#include "tests/support/chi_squared.hpp"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/pass_bench.hpp"
#include "tests/support/z_test.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <set>

namespace ockham {
namespace {

struct Draw {
    std::uint32_t seed = 7;
    std::uint32_t streams = 1, samples = 1, first_sample = 0, sets = 1, first_set = 0;
};

class RandomTest : public test::GpuTest {
protected:
    /// next4() of streams x samples x sets, sets fastest.
    static std::vector<glm::vec4> draw(const Draw& draw, bool sobol = false) {
        const std::uint32_t count = draw.streams * draw.samples * draw.sets;
        test::PassBench bench(device());
        PassBuilder pass = bench.graph.add_compute_pass("random");
        const BufferHandle numbers = pass.write("numbers",
            bench.graph.create_buffer("numbers", {std::uint64_t{count} * sizeof(glm::vec4)}));
        pass.record([=](Commands& commands) {
            commands.dispatch_over({.shader = "test/random.comp",
                                       .specialization = {{SPEC_SOBOL, sobol ? 1u : 0u}},
                                       .push = as_push(draw)},
                {count, 1, 1});
        });
        bench.graph.export_resource(numbers, "tested");
        bench.execute();
        return bench.read<glm::vec4>(numbers);
    }

    struct Hashed {
        std::vector<glm::uvec4> hashes;
        std::vector<glm::vec4> numbers;
    };
    static Hashed hash(const std::vector<glm::uvec4>& keys) {
        test::PassBench bench(device());
        const BufferHandle input = bench.buffer("keys", keys);
        PassBuilder pass = bench.graph.add_compute_pass("hash");
        pass.read("keys", input);
        const BufferHandle hashes = pass.write(
            "hashes", bench.graph.create_buffer("hashes", {keys.size() * sizeof(glm::uvec4)}));
        const BufferHandle numbers = pass.write(
            "numbers", bench.graph.create_buffer("numbers", {keys.size() * sizeof(glm::vec4)}));
        pass.record([count = static_cast<std::uint32_t>(keys.size())](Commands& commands) {
            commands.dispatch_over({.shader = "test/hash.comp"}, {count, 1, 1});
        });
        bench.graph.export_resource(hashes, "tested");
        bench.graph.export_resource(numbers, "tested");
        bench.execute();
        return {bench.read<glm::uvec4>(hashes), bench.read<glm::vec4>(numbers)};
    }
};

/// hash4() backwards, step by step.
glm::uvec4 unhash(glm::uvec4 v) {
    const auto unmix = [&] {
        v.w -= v.y * v.z;
        v.z -= v.x * v.y;
        v.y -= v.z * v.x;
        v.x -= v.y * v.w;
    };
    unmix();
    v ^= v >> 16u;
    unmix();
    std::uint32_t inverse = 1; // of 1664525 modulo 2^32, by Newton's iteration
    for (int i = 0; i < 5; ++i) inverse *= 2 - 1664525u * inverse;
    return (v - 1013904223u) * inverse;
}

/// Two components of all samples of one stream, for one set.
using Points = std::vector<glm::vec2>;

/// Star discrepancy, exactly (Niederreiter 1972): over all corners that coordinates of points make.
double star_discrepancy(const Points& points) {
    std::vector<float> xs{1.0f}, ys{1.0f};
    for (const glm::vec2& p : points) {
        xs.push_back(p.x);
        ys.push_back(p.y);
    }
    double worst = 0;
    for (const float x : xs) {
        for (const float y : ys) {
            int open = 0, closed = 0;
            for (const glm::vec2& p : points) {
                open += p.x < x && p.y < y;
                closed += p.x <= x && p.y <= y;
            }
            const double area = double{x} * y, n = static_cast<double>(points.size());
            worst = std::max({worst, area - open / n, closed / n - area});
        }
    }
    return worst;
}

TEST_F(RandomTest, ConversionNeverGivesZeroOrOne) {
    const Hashed hashed = hash({{0, 511, 512, ~0u}});
    EXPECT_EQ(hashed.numbers[0], glm::vec4(0x1p-24f, 0x1p-24f, 3 * 0x1p-24f, 1 - 0x1p-24f));
    for (const bool sobol : {false, true}) {
        for (const glm::vec4& v : draw({.streams = 1024, .samples = 128, .sets = 8}, sobol))
            for (int c = 0; c < 4; ++c) ASSERT_TRUE(v[c] > 0 && v[c] < 1);
    }
}

TEST_F(RandomTest, DifferentKeysHaveDifferentHashes) {
    Pcg32 rng(1);
    std::vector<glm::uvec4> keys{{0, 0, 0, 0}, {~0u, ~0u, ~0u, ~0u}};
    for (int i = 0; i < 100'000; ++i)
        keys.emplace_back(rng.next(), rng.next(), rng.next(), rng.next());
    const Hashed hashed = hash(keys);
    // A function that can be undone is one to one.
    for (std::size_t i = 0; i < keys.size(); ++i) ASSERT_EQ(unhash(hashed.hashes[i]), keys[i]);
}

TEST_F(RandomTest, NoTwoStreamsOfAFrameAreEqual) {
    for (const bool sobol : {false, true}) {
        const std::vector<glm::vec4> numbers =
            draw({.streams = 64 * 64, .samples = 8, .sets = 8}, sobol);
        std::vector<std::array<float, 4>> sorted;
        for (const glm::vec4& v : numbers) sorted.push_back({v.x, v.y, v.z, v.w});
        std::sort(sorted.begin(), sorted.end());
        EXPECT_EQ(std::adjacent_find(sorted.begin(), sorted.end()), sorted.end()) << sobol;
    }
}

TEST_F(RandomTest, IsUniform) {
    constexpr std::size_t kBins = 1024;
    // Of Sobol points, one sample each of many streams: those of one stream are too even.
    const std::vector<std::pair<Draw, bool>> draws{
        {{.streams = 256, .samples = 64, .sets = 16}, false},
        {{.streams = 1 << 18, .samples = 1, .first_sample = 0}, true},
        {{.streams = 1 << 18, .samples = 1, .first_sample = 5, .first_set = 3}, true},
        {{.streams = 1 << 18, .samples = 1, .first_sample = 1u << 31, .first_set = 63}, true},
        {{.streams = 1 << 12, .samples = 64, .first_set = 64}, true}};
    const double limit = test::z_limit(draws.size() * (4 + 6));
    for (const auto& [what, sobol] : draws) {
        const std::vector<glm::vec4> numbers = draw(what, sobol);
        const std::vector<double> expected(kBins, static_cast<double>(numbers.size()) / kBins);
        for (int a = 0; a < 4; ++a) {
            std::vector<std::uint64_t> bins(kBins);
            for (const glm::vec4& v : numbers) ++bins[static_cast<std::size_t>(v[a] * kBins)];
            EXPECT_LT(test::chi_squared_z(bins, expected), limit) << a;
            for (int b = 0; b < a; ++b) {
                std::vector<std::uint64_t> pairs(kBins);
                for (const glm::vec4& v : numbers)
                    ++pairs[static_cast<std::size_t>(v[a] * 32) * 32 +
                            static_cast<std::size_t>(v[b] * 32)];
                EXPECT_LT(test::chi_squared_z(pairs, expected), limit) << a << " and " << b;
            }
        }
    }
}

/// Correlation of uniform numbers at a distance in an array.
double autocorrelation(const std::vector<float>& values, std::size_t distance) {
    double sum = 0;
    for (std::size_t i = 0; i + distance < values.size(); ++i)
        sum += (double{values[i]} - 0.5) * (double{values[i + distance]} - 0.5);
    return 12 * sum / static_cast<double>(values.size() - distance);
}

TEST_F(RandomTest, NeighboursAreNotCorrelated) {
    constexpr std::uint32_t kWidth = 256; // of a picture, in pixels, which are the streams
    for (const bool sobol : {false, true}) {
        // [stream][sample][set][component]
        const std::vector<glm::vec4> numbers =
            draw({.streams = kWidth * kWidth, .samples = 2, .sets = 2}, sobol);
        std::vector<float> flat;
        for (const glm::vec4& v : numbers) flat.insert(flat.end(), {v.x, v.y, v.z, v.w});
        std::vector<float> picture; // one number per pixel
        for (std::size_t i = 0; i < flat.size(); i += 16) picture.push_back(flat[i]);
        const double pixel_limit = 4 / std::sqrt(static_cast<double>(picture.size()));
        for (const std::size_t distance : {1u, 2u, 3u, kWidth - 1, kWidth, kWidth + 1, 8 * kWidth})
            EXPECT_LT(std::abs(autocorrelation(picture, distance)), pixel_limit) << distance;
        // Components and sets. Samples of one Sobol sequence are meant to avoid each other: not 8.
        const double limit = 4 / std::sqrt(static_cast<double>(flat.size()));
        for (const std::size_t distance : {1u, 2u, 3u, 4u, 5u, 6u, 7u}) {
            double sum = 0;
            std::size_t count = 0;
            for (std::size_t i = 0; i + distance < flat.size(); ++i) {
                if (i / 8 != (i + distance) / 8) continue; // of one sample
                sum += (double{flat[i]} - 0.5) * (double{flat[i + distance]} - 0.5);
                ++count;
            }
            EXPECT_LT(std::abs(12 * sum / static_cast<double>(count)),
                4 / std::sqrt(static_cast<double>(count)))
                << distance;
        }
        if (!sobol) {
            EXPECT_LT(std::abs(autocorrelation(flat, 8)), limit);
        }
    }
}

TEST_F(RandomTest, SeedsGiveIndependentNumbers) {
    for (const bool sobol : {false, true}) {
        const std::vector<glm::vec4> a = draw({.seed = 1, .streams = 1 << 16}, sobol);
        const std::vector<glm::vec4> b = draw({.seed = 2, .streams = 1 << 16}, sobol);
        double sum = 0;
        for (std::size_t i = 0; i < a.size(); ++i)
            for (int c = 0; c < 4; ++c) sum += (double{a[i][c]} - 0.5) * (double{b[i][c]} - 0.5);
        const double n = 4 * static_cast<double>(a.size());
        EXPECT_LT(std::abs(12 * sum / n), 4 / std::sqrt(n));
        EXPECT_EQ(a, draw({.seed = 1, .streams = 1 << 16}, sobol));
    }
}

TEST_F(RandomTest, PairsOfSobolPointsAreNets) {
    constexpr std::uint32_t kSamples = 1024, kStreams = 8, kSets = 4;
    const std::vector<glm::vec4> numbers =
        draw({.streams = kStreams, .samples = kSamples, .sets = kSets, .first_set = 60}, true);
    for (std::uint32_t stream = 0; stream < kStreams; ++stream) {
        for (std::uint32_t set = 0; set < kSets; ++set) {
            const auto point = [&](std::uint32_t i) {
                return numbers[(stream * kSamples + i) * kSets + set];
            };
            // (0, m, 2)-net: of every 2^m points from a multiple of 2^m on, each rectangle of
            // 2^-a x 2^-(m-a) holds one.
            for (int m = 0; m <= 10; ++m) {
                for (std::uint32_t first = 0; first < kSamples; first += 1u << m) {
                    for (int a = 0; a <= m; ++a) {
                        std::set<std::uint32_t> xy, zw;
                        for (std::uint32_t i = first; i < first + (1u << m); ++i) {
                            const glm::uvec4 p(point(i) * static_cast<float>(1 << 20));
                            xy.insert((p.x >> (20 - a)) << (m - a) | p.y >> (20 - m + a));
                            zw.insert((p.z >> (20 - a)) << (m - a) | p.w >> (20 - m + a));
                        }
                        ASSERT_EQ(xy.size(), 1u << m) << stream << " " << set << " " << first;
                        ASSERT_EQ(zw.size(), 1u << m) << stream << " " << set << " " << first;
                    }
                }
            }
        }
    }
}

TEST_F(RandomTest, SobolPointsAreMoreEvenThanIndependentOnes) {
    constexpr std::uint32_t kStreams = 8;
    std::map<std::pair<bool, std::uint32_t>, double> mean; // over streams and pairs
    for (const bool sobol : {false, true}) {
        for (const std::uint32_t samples : {16u, 128u}) {
            const std::vector<glm::vec4> numbers =
                draw({.streams = kStreams, .samples = samples}, sobol);
            for (std::uint32_t stream = 0; stream < kStreams; ++stream) {
                Points xy, zw;
                for (std::uint32_t i = 0; i < samples; ++i) {
                    const glm::vec4& v = numbers[stream * samples + i];
                    xy.emplace_back(v.x, v.y);
                    zw.emplace_back(v.z, v.w);
                }
                mean[{sobol, samples}] +=
                    (star_discrepancy(xy) + star_discrepancy(zw)) / (2 * kStreams);
            }
        }
    }
    // Of order log(n) / n against 1 / sqrt(n).
    EXPECT_LT((mean[{true, 16}]), 0.6 * (mean[{false, 16}]));
    EXPECT_LT((mean[{true, 128}]), 0.25 * (mean[{false, 128}]));
}

TEST_F(RandomTest, SetsOfSobolPointsAreShuffledApart) {
    // Correlation over the samples of a stream between pairs of components in different sets: its
    // mean over streams is 0, and no stream has much of it.
    constexpr std::uint32_t kSamples = 64, kStreams = 4096, kSets = 2;
    const std::vector<glm::vec4> numbers =
        draw({.streams = kStreams, .samples = kSamples, .sets = kSets}, true);
    const double limit = test::z_limit(16 + 2);
    const auto judge = [&](int a, int set_a, int b, int set_b) {
        double sum = 0, squares = 0, worst = 0;
        for (std::uint32_t stream = 0; stream < kStreams; ++stream) {
            double r = 0;
            for (std::uint32_t i = 0; i < kSamples; ++i) {
                const glm::vec4* v = &numbers[(stream * kSamples + i) * kSets];
                r += 12.0 / kSamples * (double{v[set_a][a]} - 0.5) * (double{v[set_b][b]} - 0.5);
            }
            sum += r;
            squares += r * r;
            worst = std::max(worst, std::abs(r));
        }
        const double mean = sum / kStreams, variance = squares / kStreams - mean * mean;
        EXPECT_LT(std::abs(mean), limit * std::sqrt(variance / kStreams)) << a << " " << b;
        EXPECT_LT(worst, 6 / std::sqrt(double{kSamples})) << a << " " << b;
    };
    for (int a = 0; a < 4; ++a)
        for (int b = 0; b < 4; ++b) judge(a, 0, b, 1);
    judge(0, 0, 2, 0); // the two pairs of a set
    judge(1, 0, 3, 0);
}

} // namespace
} // namespace ockham

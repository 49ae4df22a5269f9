// SPDX-License-Identifier: Apache-2.0
// Coarse counts against a plain reference on synthetic maps: blocks, powers of two, both.
#include "framework/core/rng.hpp"
#include "passes/schedule/coarsen.hpp"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/pass_bench.hpp"

#include <algorithm>

namespace ockham::test {
namespace {

using Map = std::vector<std::uint8_t>;

/// The promise of add_coarsen, pixel by pixel.
Map coarsened(const Map& fine, const CoarsenParams& p) {
    Map result(fine.size());
    for (std::uint32_t y = 0; y < p.height; ++y) {
        for (std::uint32_t x = 0; x < p.width; ++x) {
            std::uint32_t k = 1;
            for (std::uint32_t v = y / p.block * p.block; v < (y / p.block + 1) * p.block; ++v) {
                for (std::uint32_t u = x / p.block * p.block; u < (x / p.block + 1) * p.block;
                     ++u) {
                    if (u < p.width && v < p.height)
                        k = std::max<std::uint32_t>(k, fine[std::size_t{v} * p.width + u]);
                }
            }
            while (!is_count_level(k, p.powers_of_two, p.n)) ++k;
            result[std::size_t{y} * p.width + x] = static_cast<std::uint8_t>(k);
        }
    }
    return result;
}

class CoarsenTest : public GpuTest {
protected:
    static void expect_coarse(const CoarsenParams& p) {
        SCOPED_TRACE(testing::Message() << p.width << "x" << p.height << ", n = " << p.n
                                        << ", block " << p.block << ", " << p.powers_of_two);
        const std::size_t pixels = std::size_t{p.width} * p.height;
        PassBench bench(device());
        const ImageHandle map =
            bench.image("sample_count", VK_FORMAT_R8_UINT, p.width, p.height, Map(pixels, 1));
        const ImageHandle coarse = bench.keep(add_coarsen(bench.graph, map, p));
        bench.graph.export_resource(coarse, "test");
        const auto expect_for = [&](const Map& fine) {
            bench.set(map, fine);
            bench.execute();
            EXPECT_EQ(bench.texels<std::uint8_t>(coarse), coarsened(fine, p));
        };
        expect_for(Map(pixels, 1));
        expect_for(Map(pixels, static_cast<std::uint8_t>(p.n)));
        Map map_of_one(pixels, 1);
        map_of_one[pixels / 2] = static_cast<std::uint8_t>(p.n);
        expect_for(map_of_one);
        Pcg32 rng(p.n + p.block);
        Map random(pixels);
        for (std::uint8_t& k : random) k = static_cast<std::uint8_t>(1 + rng.below(p.n));
        expect_for(random);
    }
};

TEST_F(CoarsenTest, BlocksTakeTheirLargestCountAndCountsTheNextPower) {
    for (const auto& [width, height] : {std::pair{1u, 1u}, {7u, 5u}, {8191u, 1u}, {67u, 35u}}) {
        for (const std::uint32_t n : {4u, 9u, 64u}) {
            for (const std::uint32_t block : {1u, 6u}) {
                for (const bool powers : {false, true})
                    expect_coarse({width, height, n, block, powers});
            }
        }
    }
}

TEST_F(CoarsenTest, LevelsArePowersOfTwoAndN) {
    std::vector<std::uint32_t> levels;
    for (std::uint32_t k = 1; k <= 9; ++k) {
        if (is_count_level(k, true, 9)) levels.push_back(k);
        EXPECT_TRUE(is_count_level(k, false, 9));
    }
    EXPECT_EQ(levels, (std::vector<std::uint32_t>{1, 2, 4, 8, 9}));
}

} // namespace
} // namespace ockham::test

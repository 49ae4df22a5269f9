// SPDX-License-Identifier: Apache-2.0
// The list of tiles with work against a plain reference: each such tile once, in Morton order.
#include "framework/core/rng.hpp"
#include "passes/schedule/tile_list.hpp"
#include "shaders/schedule/tile_list.h"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/pass_bench.hpp"

#include <algorithm>

namespace ockham::test {
namespace {

using Map = std::vector<std::uint8_t>;

/// Bits of x and y interleaved, x lowest; sorts tiles as the list is promised to be while both axes
/// have bits, and beyond: the longer axis' other bits are all above.
std::uint64_t morton(std::uint32_t x, std::uint32_t y) {
    std::uint64_t code = 0;
    for (int bit = 0; bit < 16; ++bit) {
        code |= std::uint64_t{(x >> bit) & 1u} << (2 * bit);
        code |= std::uint64_t{(y >> bit) & 1u} << (2 * bit + 1);
    }
    return code;
}

std::vector<std::uint32_t> tiles_with_work(
    const Map& map, std::uint32_t width, std::uint32_t height) {
    std::vector<std::pair<std::uint64_t, std::uint32_t>> tiles;
    for (std::uint32_t y = 0; y < height; y += 8) {
        for (std::uint32_t x = 0; x < width; x += 8) {
            bool work = false;
            for (std::uint32_t v = y; v < std::min(y + 8, height); ++v) {
                for (std::uint32_t u = x; u < std::min(x + 8, width); ++u)
                    work = work || map[std::size_t{v} * width + u] > 1;
            }
            if (work) tiles.push_back({morton(x / 8, y / 8), x / 8 | y / 8 << 16});
        }
    }
    std::sort(tiles.begin(), tiles.end());
    std::vector<std::uint32_t> list;
    for (const auto& [code, tile] : tiles) list.push_back(tile);
    return list;
}

class TileListTest : public GpuTest {};

TEST_F(TileListTest, TilesWithWorkAreListedOnceInMortonOrder) {
    for (const auto& [width, height] :
        {std::pair{1u, 1u}, {7u, 5u}, {8191u, 1u}, {1u, 300u}, {203u, 131u}}) {
        SCOPED_TRACE(testing::Message() << width << "x" << height);
        const std::size_t pixels = std::size_t{width} * height;
        PassBench bench(device());
        const ImageHandle map =
            bench.image("sample_count", VK_FORMAT_R8_UINT, width, height, Map(pixels, 1));
        const TileList tiles = add_tile_list(bench.graph, map, width, height);
        bench.graph.export_resource(tiles.list, "test");
        bench.graph.export_resource(tiles.arguments, "test");
        const auto expect_for = [&](const Map& counts) {
            bench.set(map, counts);
            bench.execute();
            const std::vector<std::uint32_t> expected = tiles_with_work(counts, width, height);
            const auto found = bench.read<std::uint32_t>(tiles.list);
            ASSERT_GE(found.size(), 1 + expected.size());
            EXPECT_EQ(found[0], expected.size());
            EXPECT_TRUE(std::equal(expected.begin(), expected.end(), found.begin() + 1));
            const auto arguments = bench.read<shader::DispatchArguments>(tiles.arguments);
            EXPECT_EQ(arguments[0].x * arguments[0].y, expected.size());
            EXPECT_EQ(arguments[0].z, 1u);
        };
        expect_for(Map(pixels, 1));
        expect_for(Map(pixels, 64));
        Map one(pixels, 1);
        one[pixels / 2] = 2;
        expect_for(one);
        Pcg32 rng(width);
        Map sparse(pixels);
        for (std::uint8_t& k : sparse) k = static_cast<std::uint8_t>(rng.below(50) == 0 ? 7 : 1);
        expect_for(sparse);
    }
}

TEST_F(TileListTest, TilesBeyond65535SpreadOverTwoAxes) {
    constexpr std::uint32_t kWidth = 4096, kHeight = 1025; // 512 x 129 tiles
    PassBench bench(device());
    const ImageHandle map = bench.image(
        "sample_count", VK_FORMAT_R8_UINT, kWidth, kHeight, Map(std::size_t{kWidth} * kHeight, 2));
    const TileList tiles = add_tile_list(bench.graph, map, kWidth, kHeight);
    bench.graph.export_resource(tiles.arguments, "test");
    bench.execute();
    const auto arguments = bench.read<shader::DispatchArguments>(tiles.arguments);
    EXPECT_EQ(arguments[0].x, 33024u);
    EXPECT_EQ(arguments[0].y, 2u);
}

} // namespace
} // namespace ockham::test

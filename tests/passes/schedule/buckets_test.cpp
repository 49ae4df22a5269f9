// SPDX-License-Identifier: Apache-2.0
// The bucket passes against a plain sort: every pixel once, in the promised order, with arguments
// that cover each bucket exactly.
#include "framework/core/rng.hpp"
#include "passes/schedule/buckets.hpp"
#include "shaders/schedule/buckets.h"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/pass_bench.hpp"

#include <algorithm>
#include <bit>
#include <tuple>

namespace ockham::test {
namespace {

struct Size {
    std::uint32_t width, height;
};

/// Place of a tile in the order: bits of x and y interleaved, x lowest, as far as both axes of the
/// padded grid have bits; the longer axis' remaining bits above them.
std::uint32_t tile_rank(std::uint32_t x, std::uint32_t y, Size size) {
    const auto bits = [](std::uint32_t pixels) { return std::bit_width((pixels + 7) / 8 - 1); };
    const int bits_x = bits(size.width), bits_y = bits(size.height);
    std::uint32_t rank = 0;
    int at = 0;
    for (int b = 0; b < std::max(bits_x, bits_y); ++b) {
        if (b < bits_x) rank |= ((x >> b) & 1u) << at++;
        if (b < bits_y) rank |= ((y >> b) & 1u) << at++;
    }
    return rank;
}

/// What add_buckets promises, by sorting.
struct Expected {
    std::vector<std::uint32_t> list;
    std::vector<std::uint32_t> counts;
};
Expected sort_pixels(Size size, std::uint32_t n, const std::vector<std::uint8_t>& map) {
    using Key = std::tuple<std::uint32_t, std::uint32_t, std::uint32_t, std::uint32_t>;
    std::vector<Key> keys; // bucket, tile, row, column
    Expected expected;
    expected.counts.assign(n, 0);
    for (std::uint32_t y = 0; y < size.height; ++y) {
        for (std::uint32_t x = 0; x < size.width; ++x) {
            const std::uint32_t k =
                std::clamp<std::uint32_t>(map[std::size_t{y} * size.width + x], 1, n);
            keys.emplace_back(k - 1, tile_rank(x / 8, y / 8, size), y, x);
            ++expected.counts[k - 1];
        }
    }
    std::sort(keys.begin(), keys.end());
    for (const auto& [bucket, tile, y, x] : keys) expected.list.push_back(x | y << 16);
    return expected;
}

class BucketsTest : public GpuTest {
protected:
    /// Sorts `map` twice and compares everything that comes out.
    class Sorter {
    public:
        Sorter(gpu::Device& device, Size size, std::uint32_t n)
            : size_(size), n_(n), bench_(device) {
            map_ = bench_.image("sample_count", VK_FORMAT_R8_UINT, size.width, size.height,
                std::vector<std::uint8_t>(std::size_t{size.width} * size.height, 1));
            buckets_ = add_buckets(bench_.graph, map_, {size.width, size.height, n});
            bench_.graph.export_resource(buckets_.table, "test");
            bench_.graph.export_resource(buckets_.arguments, "test");
            bench_.graph.export_resource(buckets_.list, "test");
        }

        void expect_sorted(const std::vector<std::uint8_t>& map) {
            bench_.set(map_, map);
            const Expected expected = sort_pixels(size_, n_, map);
            for (int run = 0; run < 2; ++run) {
                bench_.execute();
                // The executor knows the map only from the first execution on.
                ASSERT_EQ(bench_.read<std::uint32_t>(buckets_.list), expected.list);
                const auto table = bench_.read<shader::Bucket>(buckets_.table);
                const auto arguments = bench_.read<shader::DispatchArguments>(buckets_.arguments);
                ASSERT_EQ(table.size(), n_ + 1);
                // The last range holds the items of count 2 and more.
                EXPECT_EQ(table[n_].first, expected.counts[0]);
                EXPECT_EQ(table[n_].count, size_.width * size_.height - expected.counts[0]);
                EXPECT_EQ(arguments[n_].x * arguments[n_].y, (table[n_].count + 63) / 64);
                EXPECT_EQ(arguments[n_].z, 1u);
                std::uint32_t first = 0;
                for (std::uint32_t b = 0; b < n_; ++b) {
                    ASSERT_EQ(table[b].count, expected.counts[b]) << "bucket " << b;
                    ASSERT_EQ(table[b].first, first) << "bucket " << b;
                    first += table[b].count;
                    const std::uint32_t groups = (table[b].count + 63) / 64;
                    ASSERT_EQ(arguments[b].x, groups);
                    ASSERT_EQ(arguments[b].y, groups > 0 ? 1u : 0u);
                    ASSERT_EQ(arguments[b].z, 1u);
                }
                ASSERT_EQ(first, size_.width * size_.height);
            }
        }

    private:
        Size size_;
        std::uint32_t n_;
        PassBench bench_;
        ImageHandle map_;
        Buckets buckets_;
    };

    /// Counts at random, all equal, all but one equal.
    static void expect_maps_sorted(Size size, std::uint32_t n) {
        SCOPED_TRACE(testing::Message() << size.width << "x" << size.height << ", n = " << n);
        Sorter sorter(device(), size, n);
        const std::size_t pixels = std::size_t{size.width} * size.height;
        Pcg32 rng(n + size.width);
        std::vector<std::uint8_t> map(pixels);
        for (std::uint8_t& k : map) k = static_cast<std::uint8_t>(1 + rng.below(n));
        sorter.expect_sorted(map);
        std::fill(map.begin(), map.end(), std::uint8_t{1});
        sorter.expect_sorted(map);
        map[pixels / 2] = static_cast<std::uint8_t>(n);
        sorter.expect_sorted(map);
        std::fill(map.begin(), map.end(), static_cast<std::uint8_t>(n));
        sorter.expect_sorted(map);
    }
};

constexpr std::uint32_t kCounts[] = {4, 9, 16, 64};

TEST_F(BucketsTest, SmallMapsAreSortedStablyByCountTileAndRow) {
    for (const Size size : {Size{1, 1}, {7, 5}, {64, 64}, {1, 300}}) {
        for (const std::uint32_t n : kCounts) expect_maps_sorted(size, n);
    }
}

TEST_F(BucketsTest, LargeMapsAreSortedStablyByCountTileAndRow) {
    for (const Size size : {Size{67, 131}, {8191, 1}}) {
        for (const std::uint32_t n : kCounts) expect_maps_sorted(size, n);
    }
}

TEST_F(BucketsTest, CountsOutOfRangeAreClamped) {
    Sorter sorter(device(), {19, 11}, 9);
    std::vector<std::uint8_t> map(19 * 11);
    for (std::size_t i = 0; i < map.size(); ++i) map[i] = static_cast<std::uint8_t>(i % 3 * 127);
    sorter.expect_sorted(map);
}

TEST_F(BucketsTest, OneBucketHoldsEveryPixel) {
    Sorter sorter(device(), {33, 9}, 1);
    sorter.expect_sorted(std::vector<std::uint8_t>(33 * 9, 1));
}

TEST_F(BucketsTest, BucketsBeyond65535GroupsSpreadOverTwoAxes) {
    constexpr std::uint32_t kWidth = 4096, kHeight = 1025; // 65,600 workgroups of 64
    PassBench bench(device());
    const ImageHandle map = bench.image("sample_count", VK_FORMAT_R8_UINT, kWidth, kHeight,
        std::vector<std::uint8_t>(std::size_t{kWidth} * kHeight, 2));
    const Buckets buckets = add_buckets(bench.graph, map, {kWidth, kHeight, 2});
    bench.graph.export_resource(buckets.arguments, "test");
    bench.execute();
    const auto arguments = bench.read<shader::DispatchArguments>(buckets.arguments);
    EXPECT_EQ(arguments[0].x * arguments[0].y, 0u);
    EXPECT_EQ(arguments[1].x, 32800u);
    EXPECT_EQ(arguments[1].y, 2u);
    EXPECT_EQ(arguments[1].z, 1u);
}

} // namespace
} // namespace ockham::test

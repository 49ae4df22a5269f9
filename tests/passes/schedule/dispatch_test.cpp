// SPDX-License-Identifier: Apache-2.0
// Lane efficiency of the back ends on maps small enough to count by hand.
#include "passes/schedule/dispatch.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace ockham::test {
namespace {

TEST(Dispatch, EqualCountsFillEveryLane) {
    for (const float k : {1.0f, 4.0f, 64.0f}) {
        const std::vector<float> map(16 * 16, k);
        for (const Dispatch dispatch : kDispatches)
            EXPECT_EQ(lane_efficiency(map, 16, 16, dispatch, 8), 1.0);
    }
}

TEST(Dispatch, OneDearPixelHoldsItsGroup) {
    std::vector<float> map(16 * 16, 1.0f);
    map[5 * 16 + 3] = 10.0f; // 9 samples beyond the first
    const double useful = 256 + 9;
    for (const Dispatch dispatch : kDispatches) {
        // 8 lanes wait for one; repacked, nine pairs take two groups of 8.
        const double slots = dispatch == Dispatch::repack ? 16 : 72;
        EXPECT_EQ(lane_efficiency(map, 16, 16, dispatch, 8), useful / (256 + slots));
    }
}

TEST(Dispatch, BackEndsDifferOnMixedCounts) {
    // Columns of 2 and 4 samples in turns, 8 x 8 pixels: 32 pixels with 1 and 32 with 3 beyond S.
    std::vector<float> map(8 * 8);
    for (std::size_t i = 0; i < map.size(); ++i) map[i] = i % 2 == 0 ? 2.0f : 4.0f;
    const double useful = 64 + 32 + 96;
    const auto slots = [&](Dispatch dispatch) {
        return useful / lane_efficiency(map, 8, 8, dispatch, 8) - 64;
    };
    EXPECT_DOUBLE_EQ(slots(Dispatch::loop), 64 * 3);
    EXPECT_DOUBLE_EQ(slots(Dispatch::buckets), 128);
    EXPECT_DOUBLE_EQ(slots(Dispatch::sort), 128);
    EXPECT_DOUBLE_EQ(slots(Dispatch::repack), 128);
    EXPECT_DOUBLE_EQ(slots(Dispatch::depth), 64 + 64 * 3);
}

TEST(Dispatch, SortingFillsGroupsAcrossCounts) {
    // 3 pixels of 5, 6 of 3, 1 of 2 among 64: groups of 8 begin with a 5 and with a 3.
    std::vector<float> map(64, 1.0f);
    for (int i = 0; i < 10; ++i)
        map[static_cast<std::size_t>(i)] = i < 3 ? 5.0f : i < 9 ? 3.0f : 2.0f;
    const double useful = 64 + 3 * 4 + 6 * 2 + 1;
    EXPECT_DOUBLE_EQ(lane_efficiency(map, 8, 8, Dispatch::sort, 8), useful / (64 + 32 + 16));
    EXPECT_DOUBLE_EQ(lane_efficiency(map, 8, 8, Dispatch::buckets, 8), useful / (64 + 32 + 16 + 8));
}

} // namespace
} // namespace ockham::test

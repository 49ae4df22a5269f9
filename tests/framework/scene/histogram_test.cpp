// SPDX-License-Identifier: Apache-2.0
#include "framework/scene/histogram.hpp"
#include "tests/support/volume_row.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace ockham {
namespace {

using test::row_of;

TEST(HistogramTest, CountsEachCode) {
    Volume volume = row_of<std::int16_t>(VoxelType::int16, {-3, 1, 1, -3, 0, 1});
    volume.value_scale = 0.5, volume.value_offset = 10;
    const Histogram result = histogram(volume);
    EXPECT_TRUE(result.discrete);
    EXPECT_EQ(result.counts, (std::vector<std::uint64_t>{2, 0, 0, 1, 3}));
    EXPECT_EQ(result.low, 8.5);
    EXPECT_EQ(result.high, 10.5);
    EXPECT_EQ(result.greatest(0), 8.5);
    EXPECT_EQ(result.greatest(3), 10);
    EXPECT_EQ(result.greatest(4), 10.5);
    EXPECT_EQ(result.total(), 6u);
}

TEST(HistogramTest, CountsIntervalsWhereThereAreMoreCodesThanBins) {
    const Histogram result =
        histogram(row_of<std::uint16_t>(VoxelType::uint16, {0, 1, 249, 250, 500, 749, 1000}), 4);
    EXPECT_FALSE(result.discrete);
    EXPECT_EQ(result.counts, (std::vector<std::uint64_t>{3, 1, 2, 1}));
    EXPECT_EQ(result.greatest(0), 250);
    EXPECT_EQ(result.greatest(3), 1000);
}

TEST(HistogramTest, CountsIntervalsOfFloats) {
    const Histogram result =
        histogram(row_of<float>(VoxelType::float32, {-1, -0.5f, 0, 0.25f, 1}), 4);
    EXPECT_EQ(result.counts, (std::vector<std::uint64_t>{1, 1, 2, 1}));
    EXPECT_EQ(result.greatest(1), 0);
    EXPECT_EQ(result.greatest(2), 0.5);
}

TEST(HistogramTest, OfAConstantHasOneBin) {
    const Histogram result = histogram(row_of<float>(VoxelType::float32, {7, 7, 7}));
    EXPECT_EQ(result.counts, (std::vector<std::uint64_t>{3}));
    EXPECT_EQ(otsu_threshold(result), 7);
    EXPECT_EQ(percentile(result, 0.5), 7);
}

TEST(HistogramTest, SplitsTwoClassesInTheMiddleOfTheirGap) {
    // Emptiness at 0, dark matter 10 to 12, bright matter 20 to 22.
    std::vector<std::uint8_t> values(1000, 0);
    for (int i = 0; i < 30; ++i)
        for (const int value : {10, 11, 12, 20, 21, 22})
            values.push_back(static_cast<std::uint8_t>(value));
    EXPECT_EQ(otsu_threshold(histogram(row_of(VoxelType::uint8, values))), 16);
}

TEST(HistogramTest, IgnoresHowMuchEmptinessThereIs) {
    std::vector<std::uint8_t> values{10, 11, 12, 13, 30, 35, 40, 60, 61, 61, 0};
    const double few = otsu_threshold(histogram(row_of(VoxelType::uint8, values)));
    values.resize(100000, 0);
    EXPECT_EQ(otsu_threshold(histogram(row_of(VoxelType::uint8, values))), few);
}

/// Against the definition: the split that leaves the least variance within the classes.
TEST(HistogramTest, MinimisesTheVarianceWithinClasses) {
    std::vector<std::uint8_t> values(64, 3);
    std::uint32_t state = 5;
    for (int i = 0; i < 500; ++i) {
        state = state * 1664525u + 1013904223u;
        const std::uint32_t noise = state >> 27;
        values.push_back(static_cast<std::uint8_t>((i % 3 == 0 ? 90 : 60) + noise));
    }
    double best = 1e300, threshold = 0;
    for (double split = 60.5; split < 121; ++split) {
        double within = 0;
        for (const bool upper : {false, true}) {
            double n = 0, sum = 0, squares = 0;
            for (std::size_t i = 64; i < values.size(); ++i)
                if ((values[i] > split) == upper)
                    ++n, sum += values[i], squares += values[i] * values[i];
            if (n > 0) within += squares - sum * sum / n;
        }
        if (within < best) best = within, threshold = split;
    }
    EXPECT_NEAR(otsu_threshold(histogram(row_of(VoxelType::uint8, values))), threshold, 0.51);
}

TEST(HistogramTest, SplitsTwoValuesHalfway) {
    EXPECT_EQ(
        otsu_threshold(histogram(row_of<std::uint8_t>(VoxelType::uint8, {0, 0, 255}))), 127.5);
    EXPECT_EQ(otsu_threshold(histogram(row_of<std::uint8_t>(VoxelType::uint8, {4, 5}))), 4.5);
    EXPECT_NEAR(otsu_threshold(histogram(row_of<float>(VoxelType::float32, {-1, 3}))), 1, 1e-12);
}

TEST(HistogramTest, FindsPercentiles) {
    std::vector<std::uint8_t> values;
    for (int i = 1; i <= 200; ++i) values.push_back(static_cast<std::uint8_t>(i));
    const Histogram counts = histogram(row_of(VoxelType::uint8, values));
    EXPECT_EQ(percentile(counts, 0), 1);
    EXPECT_EQ(percentile(counts, 0.5), 100);
    EXPECT_EQ(percentile(counts, 0.501), 101);
    EXPECT_EQ(percentile(counts, 0.995), 199);
    EXPECT_EQ(percentile(counts, 1), 200);
}

} // namespace
} // namespace ockham

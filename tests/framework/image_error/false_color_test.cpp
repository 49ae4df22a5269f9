// SPDX-License-Identifier: Apache-2.0
#include "framework/core/false_color.hpp"
#include "framework/core/image.hpp"

#include <gtest/gtest.h>

#include <array>
#include <limits>

namespace ockham {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr Rgb8 kMagenta{255, 0, 255};

float luminance(const Rgb8& color) {
    const auto linear = [](std::uint8_t byte) {
        return srgb_decode(static_cast<float>(byte) / 255);
    };
    return 0.2126f * linear(color.r) + 0.7152f * linear(color.g) + 0.0722f * linear(color.b);
}

TEST(FalseColor, LuminanceRisesAllTheWay) {
    constexpr int kSteps = 64;
    for (int i = 1; i <= kSteps; ++i) {
        const float t = static_cast<float>(i) / kSteps, before = static_cast<float>(i - 1) / kSteps;
        EXPECT_GT(luminance(false_color(t)), luminance(false_color(before))) << "at t = " << t;
    }
}

TEST(FalseColor, ClampsAndMarksNan) {
    EXPECT_EQ(false_color(-1), false_color(0));
    EXPECT_EQ(false_color(kInfinity), false_color(1));
    EXPECT_EQ(false_color(-kInfinity), false_color(0));
    EXPECT_EQ(false_color(kNan), kMagenta);
}

TEST(FalseColor, MapsARange) {
    const std::array<float, 4> values{2, 4, 6, kNan};
    const std::vector<std::uint8_t> bytes = false_color(values, 2, 6);
    ASSERT_EQ(bytes.size(), 12u);
    const auto color = [&](std::size_t i) {
        return Rgb8{bytes[3 * i], bytes[3 * i + 1], bytes[3 * i + 2]};
    };
    EXPECT_EQ(color(0), false_color(0));
    EXPECT_EQ(color(1), false_color(0.5f));
    EXPECT_EQ(color(2), false_color(1));
    EXPECT_EQ(color(3), kMagenta);
}

TEST(FalseColor, AnEmptyRangeSplitsAtItsValue) {
    const std::array<float, 3> values{1, 2, kNan};
    const std::vector<std::uint8_t> bytes = false_color(values, 1, 1);
    EXPECT_EQ((Rgb8{bytes[0], bytes[1], bytes[2]}), false_color(0));
    EXPECT_EQ((Rgb8{bytes[3], bytes[4], bytes[5]}), false_color(1));
    EXPECT_EQ((Rgb8{bytes[6], bytes[7], bytes[8]}), kMagenta);
}

} // namespace
} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
#include "framework/core/false_color.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace ockham {
namespace {

/// Equally spaced stops, chosen so that relative luminance rises in every interval.
constexpr std::array<std::array<float, 3>, 9> kStops{
    {{{40, 8, 60}}, {{58, 38, 128}}, {{42, 79, 154}}, {{20, 115, 150}}, {{22, 145, 132}},
        {{62, 173, 100}}, {{130, 196, 66}}, {{204, 214, 60}}, {{253, 240, 160}}}};
constexpr Rgb8 kNotANumber{255, 0, 255};

} // namespace

Rgb8 false_color(float t) {
    if (std::isnan(t)) return kNotANumber;
    const float position = std::clamp(t, 0.0f, 1.0f) * static_cast<float>(kStops.size() - 1);
    const auto below = std::min(static_cast<std::size_t>(position), kStops.size() - 2);
    const float weight = position - static_cast<float>(below);
    const auto channel = [&](std::size_t c) {
        return static_cast<std::uint8_t>(
            std::lround(std::lerp(kStops[below][c], kStops[below + 1][c], weight)));
    };
    return {channel(0), channel(1), channel(2)};
}

std::vector<std::uint8_t> false_color(std::span<const float> values, float low, float high) {
    std::vector<std::uint8_t> bytes;
    bytes.reserve(3 * values.size());
    for (const float value : values) {
        // In double, so that the range of two finite floats is finite.
        const double range = double{high} - double{low};
        const double t = range > 0           ? (double{value} - double{low}) / range
                         : std::isnan(value) ? double{value}
                                             : (value > low ? 1.0 : 0.0);
        const Rgb8 color = false_color(static_cast<float>(t));
        bytes.insert(bytes.end(), {color.r, color.g, color.b});
    }
    return bytes;
}

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
// Numbers to colours for pictures of errors, costs and counts. Not for colour science. Called by
// tools that write false-colour PNGs.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace ockham {

/// Display-encoded (sRGB) bytes.
struct Rgb8 {
    std::uint8_t r = 0, g = 0, b = 0;
    friend bool operator==(const Rgb8&, const Rgb8&) = default;
};

/// Dark violet (0) over blue, green and yellow-green to pale yellow (1). Luminance rises all the
/// way, so that the order survives grey printing and colour blindness. `t` is clamped to [0,1];
/// NaN is magenta, which the map never reaches.
Rgb8 false_color(float t);

/// One colour per value, with `low` at 0 and `high` at 1 of the map, as interleaved bytes for
/// save_png_srgb. Where high <= low, values up to `low` are 0 and the others 1.
std::vector<std::uint8_t> false_color(std::span<const float> values, float low, float high);

} // namespace ockham

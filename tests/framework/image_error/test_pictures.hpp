// SPDX-License-Identifier: Apache-2.0
// Pictures defined by integers alone, for which the metrics' values are known from other programs
// (the official FLIP 1.6 tool, scikit-image 0.19.3, idiff). Used by the tests of image_error.
#pragma once

#include "framework/core/image.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string_view>
#include <vector>

namespace ockham::test_pictures {

inline constexpr int kSize = 256;

/// The high byte of a linear congruential generator.
class Bytes {
public:
    int next() {
        state_ = state_ * 1664525u + 1013904223u;
        return static_cast<int>(state_ >> 24);
    }

private:
    std::uint32_t state_ = 12345;
};

/// kSize x kSize sRGB pixels of three bytes, held as ints.
class Picture {
public:
    Picture() : values_(std::size_t{3} * kSize * kSize) {}
    int& at(int x, int y, int c) { return values_[index(x, y, c)]; }
    int at(int x, int y, int c) const { return values_[index(x, y, c)]; }
    std::vector<int>& values() { return values_; }

    /// Linear R, G, B.
    Image linear() const {
        Image image(kSize, kSize, {"R", "G", "B"});
        for (std::size_t i = 0; i < values_.size(); ++i) {
            image.plane(static_cast<int>(i % 3))[i / 3] =
                srgb_decode(static_cast<float>(values_[i]) / 255.0f);
        }
        return image;
    }

private:
    static std::size_t index(int x, int y, int c) {
        return static_cast<std::size_t>((y * kSize + x) * 3 + c);
    }
    std::vector<int> values_;
};

/// Gradients, a disc, a checker of 8 pixels, two black columns and a yellow row.
inline Picture reference() {
    Picture picture;
    for (int y = 0; y < kSize; ++y) {
        for (int x = 0; x < kSize; ++x) {
            std::array<int, 3> color{x, y, x * y / 256};
            const int dx = x - 128, dy = y - 128;
            if (dx * dx + dy * dy < 60 * 60) color = {220, 60, 40};
            if (x < 96 && y < 96 && (x / 8 + y / 8) % 2 == 1) color = {255, 255, 255};
            if (x == 200 || x == 201) color = {0, 0, 0};
            if (y == 230) color = {255, 255, 0};
            for (int c = 0; c < 3; ++c) picture.at(x, y, c) = color[static_cast<std::size_t>(c)];
        }
    }
    return picture;
}

inline Picture noise() {
    Picture picture = reference();
    Bytes bytes;
    for (int& value : picture.values()) value = std::clamp(value + bytes.next() % 33 - 16, 0, 255);
    return picture;
}

/// Rolled by one pixel to the right.
inline Picture shift() {
    const Picture from = reference();
    Picture picture;
    for (int y = 0; y < kSize; ++y) {
        for (int x = 0; x < kSize; ++x) {
            for (int c = 0; c < 3; ++c) {
                picture.at(x, y, c) = from.at((x + kSize - 1) % kSize, y, c);
            }
        }
    }
    return picture;
}

/// Box filter of 3 x 3, rounded to nearest, edge pixels repeated.
inline Picture blur() {
    const Picture from = reference();
    const auto clamp = [](int i) { return std::clamp(i, 0, kSize - 1); };
    Picture picture;
    for (int y = 0; y < kSize; ++y) {
        for (int x = 0; x < kSize; ++x) {
            for (int c = 0; c < 3; ++c) {
                int sum = 0;
                for (int j = -1; j <= 1; ++j) {
                    for (int i = -1; i <= 1; ++i) sum += from.at(clamp(x + i), clamp(y + j), c);
                }
                picture.at(x, y, c) = (sum + 4) / 9;
            }
        }
    }
    return picture;
}

inline Picture bias() {
    Picture picture = reference();
    for (int& value : picture.values()) value = std::min(value + 8, 255);
    return picture;
}

/// Linear values from 1/16 to 16.
inline Image hdr_reference() {
    Image image(kSize, kSize, {"R", "G", "B"});
    for (int y = 0; y < kSize; ++y) {
        for (int x = 0; x < kSize; ++x) {
            const int dx = x - 128, dy = y - 128;
            const bool disc = dx * dx + dy * dy < 30 * 30;
            image.at(x, y, 0) = disc ? 16.0f : std::exp2(static_cast<float>(dx) / 32.0f);
            image.at(x, y, 1) = disc ? 8.0f : std::exp2(static_cast<float>(dy) / 32.0f);
            image.at(x, y, 2) = disc ? 2.0f : static_cast<float>((x + 1) * (y + 1)) / 16384.0f;
        }
    }
    return image;
}

/// The reference times .75 to 1.25, a new factor for each value.
inline Image hdr_noise() {
    Image image = hdr_reference();
    Bytes bytes;
    for (int y = 0; y < kSize; ++y) {
        for (int x = 0; x < kSize; ++x) {
            for (int c = 0; c < 3; ++c) {
                image.at(x, y, c) *= 0.75f + 0.5f * static_cast<float>(bytes.next()) / 255.0f;
            }
        }
    }
    return image;
}

inline Image hdr_bias() {
    Image image = hdr_reference();
    for (int c = 0; c < 3; ++c) {
        for (float& value : image.plane(c)) value *= 1.1f;
    }
    return image;
}

} // namespace ockham::test_pictures

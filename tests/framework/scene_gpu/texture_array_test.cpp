// SPDX-License-Identifier: Apache-2.0
// Texture arrays on the CPU: sizes, averages in linear light, coverage of masks, stretched layers.
#include "framework/core/image.hpp"
#include "framework/core/rng.hpp"
#include "framework/scene_gpu/texture_array.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>

namespace ockham {
namespace {

using Texel = std::array<std::uint8_t, 4>;

TextureImage image_of(int width, int height, const std::function<Texel(int, int)>& texel) {
    TextureImage image{"image", width, height, {}};
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const Texel t = texel(x, y);
            image.rgba.insert(image.rgba.end(), t.begin(), t.end());
        }
    }
    return image;
}

/// Channel `c` of texel (x, y) of a level of a layer.
int texel_at(const TextureArray& array, std::uint32_t layer, std::uint32_t level, std::uint32_t x,
    std::uint32_t y, std::uint32_t c) {
    const std::uint32_t width = mip_size(array.width, level);
    return array.texels[layer * array.mips + level][4 * (y * width + x) + c];
}

TEST(TextureArray, HasTheLargestSidesAndAllMips) {
    const TextureImage wide = image_of(20, 3, [](int, int) { return Texel{1, 2, 3, 4}; });
    const TextureImage high = image_of(5, 9, [](int, int) { return Texel{1, 2, 3, 4}; });
    const TextureArray array = build_texture_array({{&wide, {}}, {&high, {}}}, false);
    EXPECT_EQ(array.width, 20u);
    EXPECT_EQ(array.height, 9u);
    EXPECT_EQ(array.layers, 2u);
    EXPECT_EQ(array.mips, 5u) << "20 10 5 2 1";
    ASSERT_EQ(array.texels.size(), 10u);
    const std::uint32_t sizes[5][2] = {{20, 9}, {10, 4}, {5, 2}, {2, 1}, {1, 1}};
    std::uint64_t bytes = 0;
    for (std::uint32_t layer = 0; layer < 2; ++layer) {
        for (std::uint32_t level = 0; level < 5; ++level) {
            const std::size_t expected = 4 * sizes[level][0] * sizes[level][1];
            EXPECT_EQ(array.texels[layer * 5 + level].size(), expected);
            bytes += expected;
        }
    }
    EXPECT_EQ(array.bytes(), bytes);
    // 20x3 10x1 5x1 2x1 1x1, and 5x9 2x4 1x2 1x1: without padding.
    EXPECT_LE(array.native_bytes, 4u * (60 + 10 + 5 + 2 + 1 + 45 + 8 + 2 + 1));
    EXPECT_GE(array.native_bytes, 4u * (60 + 10 + 5 + 2 + 45 + 8 + 2));
}

TEST(TextureArray, ConstantStaysConstantOnEveryLevelAndLayer) {
    const Texel color{200, 3, 77, 128};
    const TextureImage odd = image_of(13, 7, [&](int, int) { return color; });
    const TextureImage large = image_of(32, 64, [&](int, int) { return color; });
    for (const bool srgb : {false, true}) {
        const TextureArray array = build_texture_array({{&odd, {}}, {&large, {}}}, srgb);
        for (const std::vector<std::uint8_t>& level : array.texels)
            for (std::size_t i = 0; i < level.size(); ++i) ASSERT_EQ(level[i], color[i % 4]);
    }
}

TEST(TextureArray, EveryCodeSurvives) {
    const TextureImage ramp = image_of(256, 1, [](int x, int) {
        const auto code = static_cast<std::uint8_t>(x);
        return Texel{code, code, code, code};
    });
    for (const bool srgb : {false, true})
        EXPECT_EQ(build_texture_array({{&ramp, {}}}, srgb).texels[0], ramp.rgba);
}

TEST(TextureArray, HalvesByExactAreas) {
    const std::uint8_t codes[5] = {10, 20, 60, 100, 250};
    const TextureImage row = image_of(5, 1, [&](int x, int) { return Texel{codes[x], 0, 0, 255}; });
    const TextureArray array = build_texture_array({{&row, {}}}, false);
    ASSERT_EQ(array.mips, 3u);
    EXPECT_EQ(texel_at(array, 0, 1, 0, 0, 0), 24) << "(10 + 20 + 60 / 2) / 2.5";
    EXPECT_EQ(texel_at(array, 0, 1, 1, 0, 0), 152) << "(60 / 2 + 100 + 250) / 2.5";
    EXPECT_EQ(texel_at(array, 0, 2, 0, 0, 0), 88) << "440 / 5";
}

TEST(TextureArray, AveragesColourAsLight) {
    const TextureImage checker = image_of(2, 2, [](int x, int y) {
        const std::uint8_t c = (x + y) % 2 ? 255 : 0;
        return Texel{c, c, c, 255};
    });
    const TextureArray color = build_texture_array({{&checker, {}}}, true);
    const TextureArray data = build_texture_array({{&checker, {}}}, false);
    EXPECT_EQ(texel_at(color, 0, 1, 0, 0, 0), 188) << "half the light";
    EXPECT_EQ(texel_at(data, 0, 1, 0, 0, 0), 128) << "half the number";
}

TEST(TextureArray, KeepsTheMeanOverAllLevels) {
    Pcg32 rng(9);
    const TextureImage noise = image_of(37, 22, [&](int, int) {
        const auto byte = [&] { return static_cast<std::uint8_t>(rng.below(256)); };
        return Texel{byte(), byte(), byte(), byte()};
    });
    const TextureArray array = build_texture_array({{&noise, {}}}, true);
    const auto mean = [&](std::uint32_t level) { // linear
        double sum = 0;
        const std::vector<std::uint8_t>& texels = array.texels[level];
        for (std::size_t i = 0; i < texels.size(); i += 4)
            sum += srgb_decode(static_cast<float>(texels[i]) / 255);
        return sum / (static_cast<double>(texels.size()) / 4);
    };
    const double wanted = mean(0);
    for (std::uint32_t level = 1; level < array.mips; ++level)
        EXPECT_NEAR(mean(level), wanted, 0.004) << "level " << level << ": half a code";
}

TEST(TextureArray, MaskKeepsItsCoverage) {
    // Round leaves of several sizes with soft edges.
    Pcg32 rng(2);
    std::vector<std::array<float, 3>> leaves;
    for (int i = 0; i < 40; ++i)
        leaves.push_back({rng.uniform(0, 128), rng.uniform(0, 128), rng.uniform(3, 12)});
    const TextureImage mask = image_of(128, 128, [&](int x, int y) {
        float alpha = 0;
        for (const auto& [cx, cy, radius] : leaves) {
            const float distance =
                std::hypot(static_cast<float>(x) - cx, static_cast<float>(y) - cy);
            alpha = std::max(alpha, std::clamp(radius - distance, 0.0f, 1.0f));
        }
        return Texel{30, 160, 40, static_cast<std::uint8_t>(255 * alpha)};
    });
    constexpr float kCutoff = 0.5f;
    const auto coverage = [&](const TextureArray& array, std::uint32_t level) {
        std::size_t above = 0;
        const std::vector<std::uint8_t>& texels = array.texels[level];
        for (std::size_t i = 3; i < texels.size(); i += 4)
            above += static_cast<float>(texels[i]) / 255 >= kCutoff;
        return static_cast<double>(above) / (static_cast<double>(texels.size()) / 4);
    };
    const TextureArray array = build_texture_array({{&mask, kCutoff}}, true);
    const double wanted = coverage(array, 0);
    ASSERT_GT(wanted, 0.1);
    ASSERT_LT(wanted, 0.9);
    for (std::uint32_t level = 1; level <= 4; ++level) // to 8 x 8
        EXPECT_NEAR(coverage(array, level), wanted, 0.02) << "level " << level;
    // Without the cut-off, alpha is averaged like everything else.
    const TextureArray plain = build_texture_array({{&mask, {}}}, true);
    EXPECT_NE(plain.texels[3], array.texels[3]);
}

TEST(TextureArray, HolesDoNotBleedIntoLeaves) {
    const TextureImage mask = image_of(8, 8, [](int x, int) {
        return x % 2 ? Texel{0, 0, 0, 0} : Texel{40, 200, 60, 255};
    });
    const TextureArray array = build_texture_array({{&mask, 0.5f}}, true);
    for (std::uint32_t level = 1; level < array.mips; ++level) {
        EXPECT_EQ(texel_at(array, 0, level, 0, 0, 0), 40);
        EXPECT_EQ(texel_at(array, 0, level, 0, 0, 1), 200);
    }
}

TEST(TextureArray, StretchedLayersKeepTheirTexels) {
    Pcg32 rng(1);
    const TextureImage small = image_of(4, 4, [&](int, int) {
        return Texel{static_cast<std::uint8_t>(rng.below(256)), 9, 9, 255};
    });
    const TextureImage large = image_of(12, 12, [](int, int) { return Texel{}; });
    const TextureArray array = build_texture_array({{&small, {}}, {&large, {}}}, true);
    for (std::uint32_t y = 0; y < 4; ++y) {
        for (std::uint32_t x = 0; x < 4; ++x) { // three to one: every third centre coincides
            EXPECT_EQ(texel_at(array, 0, 0, 3 * x + 1, 3 * y + 1, 0),
                static_cast<int>(small.rgba[4 * (4 * y + x)]));
        }
    }
    // Between them it wraps around: the border mixes the first and the last column.
    const auto light = [&](std::uint32_t x) {
        return srgb_decode(static_cast<float>(small.rgba[4 * x]) / 255);
    };
    const float wanted = srgb_encode((2 * light(0) + light(3)) / 3);
    const float row = static_cast<float>(texel_at(array, 0, 0, 0, 1, 0)) / 255;
    EXPECT_NEAR(row, wanted, 0.6f / 255);
}

} // namespace
} // namespace ockham

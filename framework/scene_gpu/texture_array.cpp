// SPDX-License-Identifier: Apache-2.0
#include "framework/scene_gpu/texture_array.hpp"

#include "framework/core/error.hpp"
#include "framework/core/image.hpp"

#include <glm/glm.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <tuple>

namespace ockham {
namespace {

/// One mip level in linear floats.
struct Level {
    std::uint32_t width = 0, height = 0;
    std::vector<glm::vec4> texels;
    const glm::vec4& at(std::uint32_t x, std::uint32_t y) const {
        return texels[std::size_t{y} * width + x];
    }
};

const std::array<float, 256>& decode_table(bool srgb) {
    static const auto make = [](bool encoded) {
        std::array<float, 256> table{};
        for (int i = 0; i < 256; ++i) {
            const float c = static_cast<float>(i) / 255.0f;
            table[static_cast<std::size_t>(i)] = encoded ? srgb_decode(c) : c;
        }
        return table;
    };
    static const std::array<float, 256> tables[2] = {make(false), make(true)};
    return tables[srgb ? 1 : 0];
}

std::uint8_t quantise(float c) {
    return static_cast<std::uint8_t>(std::clamp(c, 0.0f, 1.0f) * 255.0f + 0.5f);
}

/// Encodes linear [0,1] by a table fine enough for 8 bits: the darkest sRGB step spans 20 entries.
std::uint8_t quantise_srgb(float c) {
    constexpr int kSteps = 1 << 16;
    static const std::vector<std::uint8_t> table = [] {
        std::vector<std::uint8_t> t(kSteps + 1);
        for (int i = 0; i <= kSteps; ++i)
            t[static_cast<std::size_t>(i)] = quantise(srgb_encode(static_cast<float>(i) / kSteps));
        return t;
    }();
    return table[static_cast<std::size_t>(std::clamp(c, 0.0f, 1.0f) * kSteps + 0.5f)];
}

Level decode(const TextureImage& image, bool srgb) {
    Level level{
        static_cast<std::uint32_t>(image.width), static_cast<std::uint32_t>(image.height), {}};
    const std::array<float, 256>& color = decode_table(srgb);
    const std::array<float, 256>& linear = decode_table(false);
    level.texels.resize(std::size_t{level.width} * level.height);
    for (std::size_t i = 0; i < level.texels.size(); ++i) {
        const std::uint8_t* t = &image.rgba[4 * i];
        level.texels[i] = {color[t[0]], color[t[1]], color[t[2]], linear[t[3]]};
    }
    return level;
}

/// Source texels under one target texel along an axis, with their weights.
struct Coverage {
    std::uint32_t first = 0;
    std::vector<float> weights;
};

std::vector<Coverage> box_coverage(std::uint32_t source, std::uint32_t target) {
    std::vector<Coverage> all(target);
    const double scale = static_cast<double>(source) / target;
    for (std::uint32_t i = 0; i < target; ++i) {
        const double low = i * scale, high = (i + 1) * scale;
        all[i].first = static_cast<std::uint32_t>(low);
        for (std::uint32_t s = all[i].first; s < source && s < high; ++s) {
            all[i].weights.push_back(
                static_cast<float>((std::min(high, s + 1.0) - std::max(low, double(s))) / scale));
        }
    }
    return all;
}

/// Half the size by exact area averages. With `by_alpha`, colour counts as much as it is opaque,
/// so that what lies under holes does not bleed into leaves.
Level halve(const Level& source, bool by_alpha) {
    Level target{mip_size(source.width, 1), mip_size(source.height, 1), {}};
    target.texels.resize(std::size_t{target.width} * target.height);
    const std::vector<Coverage> across = box_coverage(source.width, target.width);
    const std::vector<Coverage> down = box_coverage(source.height, target.height);
    for (std::uint32_t y = 0; y < target.height; ++y) {
        for (std::uint32_t x = 0; x < target.width; ++x) {
            glm::vec4 sum(0.0f), plain(0.0f);
            for (std::size_t j = 0; j < down[y].weights.size(); ++j) {
                for (std::size_t i = 0; i < across[x].weights.size(); ++i) {
                    const glm::vec4& t = source.at(across[x].first + static_cast<std::uint32_t>(i),
                        down[y].first + static_cast<std::uint32_t>(j));
                    const float weight = down[y].weights[j] * across[x].weights[i];
                    plain += weight * t;
                    if (by_alpha) sum += weight * t.w * glm::vec4(t.x, t.y, t.z, 1.0f);
                }
            }
            glm::vec4& result = target.texels[std::size_t{y} * target.width + x];
            result = plain;
            if (by_alpha && sum.w > 1e-4f) result = glm::vec4(glm::vec3(sum) / sum.w, plain.w);
        }
    }
    return target;
}

double share_above(const Level& level, float cutoff, float scale) {
    const auto above = std::count_if(level.texels.begin(), level.texels.end(),
        [&](const glm::vec4& t) { return t.w * scale >= cutoff; });
    return static_cast<double>(above) / static_cast<double>(level.texels.size());
}

/// Scales alpha so that the share of texels above the cut-off is that of the full image: distant
/// foliage neither thins out nor fills up (Castano, Computing Alpha Mipmaps, 2010).
void keep_coverage(Level& level, float cutoff, double wanted) {
    float low = 0.0f, high = 8.0f;
    for (int i = 0; i < 16; ++i) {
        const float middle = 0.5f * (low + high);
        (share_above(level, cutoff, middle) < wanted ? low : high) = middle;
    }
    for (glm::vec4& t : level.texels) t.w = std::min(t.w * high, 1.0f);
}

std::vector<std::uint8_t> encode(const Level& level, bool srgb) {
    std::vector<std::uint8_t> bytes(4 * level.texels.size());
    for (std::size_t i = 0; i < level.texels.size(); ++i) {
        const glm::vec4& t = level.texels[i];
        for (int c = 0; c < 3; ++c) {
            bytes[4 * i + static_cast<std::size_t>(c)] =
                srgb ? quantise_srgb(t[c]) : quantise(t[c]);
        }
        bytes[4 * i + 3] = quantise(t.w);
    }
    return bytes;
}

/// The level over a larger (or equal) grid, bilinear between texel centres, wrapping around.
Level stretch(const Level& source, std::uint32_t width, std::uint32_t height) {
    if (source.width == width && source.height == height) return source;
    struct Tap {
        std::uint32_t low, high;
        float weight;
    };
    const auto taps = [](std::uint32_t from, std::uint32_t to) {
        std::vector<Tap> all(to);
        for (std::uint32_t i = 0; i < to; ++i) {
            const float at =
                (static_cast<float>(i) + 0.5f) * static_cast<float>(from) / static_cast<float>(to) -
                0.5f;
            const float floor = std::floor(at);
            const auto low = static_cast<std::int64_t>(floor) + from;
            all[i] = {static_cast<std::uint32_t>(low % from),
                static_cast<std::uint32_t>((low + 1) % from), at - floor};
        }
        return all;
    };
    const std::vector<Tap> across = taps(source.width, width), down = taps(source.height, height);
    Level target{width, height, {}};
    target.texels.resize(std::size_t{width} * height);
    for (std::uint32_t y = 0; y < height; ++y) {
        for (std::uint32_t x = 0; x < width; ++x) {
            const Tap &u = across[x], &v = down[y];
            target.texels[std::size_t{y} * width + x] = glm::mix(
                glm::mix(source.at(u.low, v.low), source.at(u.high, v.low), u.weight),
                glm::mix(source.at(u.low, v.high), source.at(u.high, v.high), u.weight), v.weight);
        }
    }
    return target;
}

} // namespace

std::uint64_t TextureArray::bytes() const {
    std::uint64_t sum = 0;
    for (const auto& level : texels) sum += level.size();
    return sum;
}

std::pair<std::uint32_t, std::uint32_t> texture_array_size(const std::vector<TextureLayer>& layers) {
    std::uint32_t width = 0, height = 0;
    for (const TextureLayer& layer : layers) {
        width = std::max(width, static_cast<std::uint32_t>(layer.image->width));
        height = std::max(height, static_cast<std::uint32_t>(layer.image->height));
    }
    return {width, height};
}

TextureArray build_texture_array(const std::vector<TextureLayer>& layers, bool srgb) {
    check(!layers.empty(), "a texture array has at least one layer");
    TextureArray array;
    array.srgb = srgb;
    array.layers = static_cast<std::uint32_t>(layers.size());
    std::tie(array.width, array.height) = texture_array_size(layers);
    array.mips = static_cast<std::uint32_t>(std::bit_width(std::max(array.width, array.height)));
    array.texels.reserve(std::size_t{array.layers} * array.mips);
    for (const TextureLayer& layer : layers) {
        Level native = decode(*layer.image, srgb);
        const double coverage =
            layer.alpha_cutoff ? share_above(native, *layer.alpha_cutoff, 1.0f) : 0.0;
        for (std::uint32_t l = 0; l < array.mips; ++l) {
            if (l > 0 && (native.width > 1 || native.height > 1)) {
                native = halve(native, layer.alpha_cutoff.has_value());
            }
            if (l == 0 || native.texels.size() > 1) array.native_bytes += 4 * native.texels.size();
            Level shown = native;
            if (layer.alpha_cutoff && l > 0) keep_coverage(shown, *layer.alpha_cutoff, coverage);
            array.texels.push_back(
                encode(stretch(shown, mip_size(array.width, l), mip_size(array.height, l)), srgb));
        }
    }
    return array;
}

} // namespace ockham

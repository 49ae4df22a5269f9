// SPDX-License-Identifier: Apache-2.0
#include "framework/io/png.hpp"

#include "framework/core/error.hpp"
#include "framework/core/file.hpp"
#include "framework/core/log.hpp"

#include <stb/stb_image.h>
#include <stb/stb_image_write.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <memory>
#include <string_view>
#include <vector>

namespace ockham {
namespace {

constexpr std::int64_t kMaxValues = std::int64_t{1} << 28;
constexpr std::array<unsigned char, 8> kSignature{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
constexpr std::size_t kChunkFrame = 12; // length, type, checksum
/// Pixels, of one bit at least, that a byte may unpack to: deflate has the ratio 1032.
constexpr std::int64_t kMaxPixelsPerByte = 8 * 1032;

std::uint8_t to_byte(float unit) {
    return static_cast<std::uint8_t>(std::lround(std::clamp(unit, 0.0f, 1.0f) * 255.0f));
}

/// CRC-32 as in ISO 3309, the checksum of PNG chunks.
std::uint32_t crc32(std::span<const unsigned char> bytes) {
    static const std::array<std::uint32_t, 256> kTable = [] {
        std::array<std::uint32_t, 256> table{};
        for (std::uint32_t i = 0; i < 256; ++i) {
            std::uint32_t value = i;
            for (int bit = 0; bit < 8; ++bit) {
                value = (value >> 1) ^ ((value & 1u) != 0 ? 0xedb88320u : 0u);
            }
            table[i] = value;
        }
        return table;
    }();
    std::uint32_t crc = ~0u;
    for (const unsigned char byte : bytes) crc = (crc >> 8) ^ kTable[(crc ^ byte) & 0xffu];
    return ~crc;
}

std::uint32_t big_endian(std::span<const unsigned char> bytes) {
    return std::uint32_t{bytes[0]} << 24 | std::uint32_t{bytes[1]} << 16 |
           std::uint32_t{bytes[2]} << 8 | std::uint32_t{bytes[3]};
}

/// Walks the chunks up to IEND. The decoder does not look at checksums, so that a damaged file
/// would come out as a wrong picture.
void check_chunks(std::span<const unsigned char> file, const std::string& path) {
    if (file.size() < kSignature.size() ||
        !std::equal(kSignature.begin(), kSignature.end(), file.begin())) {
        fail_input("cannot read '{}' as PNG: it does not begin with PNG's signature", path);
    }
    for (std::size_t at = kSignature.size(); file.size() - at >= kChunkFrame;) {
        const std::size_t length = big_endian(file.subspan(at, 4));
        if (length > file.size() - at - kChunkFrame) break;
        const auto body = file.subspan(at + 4, 4 + length);
        if (crc32(body) != big_endian(file.subspan(at + 8 + length, 4))) {
            fail_input("cannot read '{}' as PNG: the chunk at byte {} is damaged (its checksum is "
                       "wrong)",
                path, at);
        }
        if (std::memcmp(body.data(), "IEND", 4) == 0) return;
        at += kChunkFrame + length;
    }
    fail_input(
        "cannot read '{}' as PNG: the file ends too early, after {} bytes", path, file.size());
}

struct FreePixels {
    void operator()(void* pixels) const { stbi_image_free(pixels); }
};

/// Interleaved pixels to planes; a grey value goes to all three colours.
template <class Value>
Image to_linear(const Value* pixels, int width, int height, int components) {
    // One entry per code value: decoding costs one power each and not one per pixel.
    constexpr auto kMaxValue = static_cast<std::size_t>(std::numeric_limits<Value>::max());
    std::vector<float> linear(kMaxValue + 1);
    for (std::size_t i = 0; i <= kMaxValue; ++i) {
        linear[i] = srgb_decode(static_cast<float>(i) / static_cast<float>(kMaxValue));
    }
    const bool grey = components < 3;
    const bool alpha = components % 2 == 0;
    Image image(width, height, {"R", "G", "B"});
    if (alpha) image.add_channel("A");
    const auto stride = static_cast<std::size_t>(components);
    for (int c = 0; c < 3; ++c) {
        const std::span<float> plane = image.plane(c);
        const Value* source = pixels + (grey ? 0 : c);
        for (std::size_t i = 0; i < plane.size(); ++i) plane[i] = linear[source[i * stride]];
    }
    if (alpha) {
        const std::span<float> plane = image.plane(3);
        const Value* source = pixels + stride - 1;
        for (std::size_t i = 0; i < plane.size(); ++i) {
            plane[i] = static_cast<float>(source[i * stride]) / static_cast<float>(kMaxValue);
        }
    }
    return image;
}

void save_bytes(const std::filesystem::path& path, int width, int height, int components,
    std::span<const std::uint8_t> pixels) {
    check(width >= 1 && height >= 1, "an image to save has pixels");
    const std::size_t row = static_cast<std::size_t>(width) * static_cast<std::size_t>(components);
    check(pixels.size() == row * static_cast<std::size_t>(height), "PNG bytes fit the size");
    // The encoder counts bytes, with a filter byte per row, in an int.
    if ((row + 1) * static_cast<std::size_t>(height) > static_cast<std::size_t>(kMaxValues)) {
        fail_input(
            "cannot write '{}': {} x {} pixels are more than a PNG may have here ({} bytes); "
            "write EXR",
            path.string(), width, height, kMaxValues);
    }
    std::vector<std::byte> encoded;
    const auto append = [](void* target, void* data, int count) {
        const auto* begin = static_cast<const std::byte*>(data);
        static_cast<std::vector<std::byte>*>(target)->assign(begin, begin + count);
    };
    if (stbi_write_png_to_func(append, &encoded, width, height, components, pixels.data(),
            static_cast<int>(row)) == 0 ||
        encoded.empty()) {
        fail_input("cannot write '{}': PNG encoding of {} x {} pixels ran out of memory",
            path.string(), width, height);
    }
    write_file(path, encoded);
}

} // namespace

float tonemap(float linear, Tonemap curve) {
    if (std::isnan(linear)) return 0.0f;
    // Beyond 1000 the curve is 1 to 8 bits, and squaring could overflow.
    const float x = std::clamp(linear, 0.0f, 1000.0f);
    if (curve == Tonemap::none) return std::min(x, 1.0f);
    const float exposed = 0.6f * x;
    return std::min(
        1.0f, exposed * (2.51f * exposed + 0.03f) / (exposed * (2.43f * exposed + 0.59f) + 0.14f));
}

void save_png8(const std::filesystem::path& path, const Image& image, float exposure_ev,
    Tonemap curve, bool alpha) {
    const int components = alpha ? 4 : 3;
    constexpr std::array<std::string_view, 4> kNames{"R", "G", "B", "A"};
    std::vector<std::uint8_t> bytes(image.pixels() * static_cast<std::size_t>(components));
    const float scale = std::exp2(exposure_ev);
    std::size_t nans = 0;
    for (int c = 0; c < components; ++c) {
        const std::string_view name = kNames[static_cast<std::size_t>(c)];
        if (!image.find(name)) {
            fail_input("cannot write '{}': a PNG needs channel {}, the image has {}", path.string(),
                name, fmt::join(image.channels(), ", "));
        }
        const std::span<const float> plane = image.plane(name);
        for (std::size_t i = 0; i < plane.size(); ++i) {
            nans += std::isnan(plane[i]);
            const float unit = name == "A" ? tonemap(plane[i], Tonemap::none)
                                           : srgb_encode(tonemap(plane[i] * scale, curve));
            bytes[i * static_cast<std::size_t>(components) + static_cast<std::size_t>(c)] =
                to_byte(unit);
        }
    }
    save_bytes(path, image.width(), image.height(), components, bytes);
    if (nans > 0)
        log::warning("'{}': {} values are NaN and were written as 0", path.string(), nans);
}

void save_png_srgb(
    const std::filesystem::path& path, int width, int height, std::span<const std::uint8_t> rgb) {
    save_bytes(path, width, height, 3, rgb);
}

Image load_png(const std::filesystem::path& path) {
    const std::vector<std::byte> bytes =
        read_file(path, static_cast<std::size_t>(std::numeric_limits<int>::max()));
    const std::span file(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
    check_chunks(file, path.string());
    const int size = static_cast<int>(file.size());
    int width = 0, height = 0, components = 0;
    if (stbi_info_from_memory(file.data(), size, &width, &height, &components) == 0) {
        fail_input("cannot read '{}' as PNG: {}", path.string(), stbi_failure_reason());
    }
    if (std::int64_t{width} * height > kMaxValues / components) {
        fail_input("cannot read '{}' as PNG: it has {} x {} pixels of {} channels, the limit is {} "
                   "values",
            path.string(), width, height, components, kMaxValues);
    }
    if (std::int64_t{width} * height > kMaxPixelsPerByte * size) {
        fail_input("cannot read '{}' as PNG: its {} x {} pixels cannot be in its {} bytes",
            path.string(), width, height, size);
    }
    const auto decode = [&](auto* load, auto value) {
        using Value = decltype(value);
        const std::unique_ptr<Value, FreePixels> pixels(
            load(file.data(), size, &width, &height, &components, 0));
        if (!pixels) {
            fail_input("cannot read '{}' as PNG: {}", path.string(), stbi_failure_reason());
        }
        return to_linear(pixels.get(), width, height, components);
    };
    try {
        return stbi_is_16_bit_from_memory(file.data(), size) != 0
                   ? decode(stbi_load_16_from_memory, stbi_us{})
                   : decode(stbi_load_from_memory, stbi_uc{});
    } catch (const std::bad_alloc&) {
        fail_input("cannot read '{}' as PNG: out of memory", path.string());
    }
}

} // namespace ockham

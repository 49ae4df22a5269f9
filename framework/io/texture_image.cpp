// SPDX-License-Identifier: Apache-2.0
#include "framework/io/texture_image.hpp"

#include "framework/core/error.hpp"

#include <stb_image.h>

#include <cstdint>
#include <limits>
#include <memory>

namespace ockham {
namespace {

constexpr int kMaxSide = 16384;
/// Pixels that a byte may unpack to: of PNG (deflate, one bit each); JPEG and others have fewer.
constexpr std::int64_t kMaxPixelsPerByte = 8 * 1032;

} // namespace

TextureImage decode_texture(std::span<const std::byte> encoded) {
    if (encoded.empty()) fail_input("the picture has no data");
    if (encoded.size() > std::numeric_limits<int>::max()) {
        fail_input("the picture has {} bytes, at most 2 GiB are accepted", encoded.size());
    }
    const auto* bytes = reinterpret_cast<const stbi_uc*>(encoded.data());
    const auto size = static_cast<int>(encoded.size());
    TextureImage image;
    int channels = 0;
    if (!stbi_info_from_memory(bytes, size, &image.width, &image.height, &channels)) {
        fail_input("not a picture of a known format (PNG, JPEG)");
    }
    if (image.width < 1 || image.height < 1 || image.width > kMaxSide || image.height > kMaxSide) {
        fail_input("the picture has {} x {} pixels, sides from 1 to {} are accepted", image.width,
            image.height, kMaxSide);
    }
    if (std::int64_t{image.width} * image.height > kMaxPixelsPerByte * size) {
        fail_input("the picture's {} x {} pixels cannot be in its {} bytes", image.width,
            image.height, size);
    }
    const std::unique_ptr<stbi_uc, void (*)(void*)> pixels(
        stbi_load_from_memory(bytes, size, &image.width, &image.height, &channels, 4),
        stbi_image_free);
    if (!pixels) fail_input("the picture is damaged: {}", stbi_failure_reason());
    const std::size_t count = std::size_t{4} * image.width * image.height;
    image.rgba.assign(pixels.get(), pixels.get() + count);
    return image;
}

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
#include "framework/core/image.hpp"

#include "framework/core/error.hpp"

#include <algorithm>
#include <cmath>

namespace ockham {

Image::Image(int width, int height, std::vector<std::string> channels)
    : width_(width), height_(height), channels_(std::move(channels)) {
    check(width >= 1 && height >= 1, "an image has at least one pixel");
    planes_.assign(channels_.size(), std::vector<float>(pixels(), 0.0f));
}

std::size_t Image::pixels() const {
    return static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
}

std::optional<int> Image::find(std::string_view channel) const {
    const auto found = std::find(channels_.begin(), channels_.end(), channel);
    if (found == channels_.end()) return std::nullopt;
    return static_cast<int>(found - channels_.begin());
}

std::span<float> Image::plane(std::string_view channel) {
    const std::optional<int> index = find(channel);
    check(index.has_value(), "the image has no such channel");
    return plane(*index);
}

std::span<const float> Image::plane(std::string_view channel) const {
    const std::optional<int> index = find(channel);
    check(index.has_value(), "the image has no such channel");
    return plane(*index);
}

std::span<float> Image::plane(int channel) { return planes_.at(static_cast<std::size_t>(channel)); }

std::span<const float> Image::plane(int channel) const {
    return planes_.at(static_cast<std::size_t>(channel));
}

std::span<float> Image::add_channel(const std::string& channel) {
    if (const std::optional<int> index = find(channel)) return plane(*index);
    channels_.push_back(channel);
    return planes_.emplace_back(pixels(), 0.0f);
}

float& Image::at(int x, int y, int channel) {
    return planes_[static_cast<std::size_t>(channel)]
                  [static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                      static_cast<std::size_t>(x)];
}

float Image::at(int x, int y, int channel) const {
    return planes_[static_cast<std::size_t>(channel)]
                  [static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                      static_cast<std::size_t>(x)];
}

float srgb_encode(float linear) {
    const float c = std::clamp(linear, 0.0f, 1.0f);
    if (c >= 1.0f) return 1.0f; // exactly, which the formula misses by an ulp
    return c <= 0.0031308f ? 12.92f * c : 1.055f * std::pow(c, 1.0f / 2.4f) - 0.055f;
}

float srgb_decode(float encoded) {
    const float c = std::clamp(encoded, 0.0f, 1.0f);
    return c <= 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f);
}

} // namespace ockham

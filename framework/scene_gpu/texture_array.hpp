// SPDX-License-Identifier: Apache-2.0
// Images of many sizes as layers of one array with mips, on the CPU. Mip level l of a layer holds
// its image at 1/2^l of the image's own size, stretched over the layer; shaders choose levels by
// native size (include/footprint.glsl). Called by scene_gpu only.
#pragma once

#include "framework/scene/material.hpp"

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace ockham {

/// One layer to build.
struct TextureLayer {
    const TextureImage* image = nullptr;
    /// Cut-off of a masked material that uses it: each mip keeps the share of texels above it.
    std::optional<float> alpha_cutoff;
};

/// RGBA8 texels, layer-major: `texels[layer * mips + level]` has 4 * width(level) * height(level)
/// bytes.
struct TextureArray {
    std::uint32_t width = 0, height = 0, mips = 0, layers = 0;
    bool srgb = false;
    std::vector<std::vector<std::uint8_t>> texels;

    std::uint64_t native_bytes = 0; ///< of the images with their mips, without the padding

    std::uint64_t bytes() const; ///< of all texels
};

/// Size of a mip level: max(1, size >> level).
constexpr std::uint32_t mip_size(std::uint32_t size, std::uint32_t level) {
    return (size >> level) > 0 ? size >> level : 1u;
}

/// Largest width and height among the images: the size of every layer.
std::pair<std::uint32_t, std::uint32_t> texture_array_size(const std::vector<TextureLayer>& layers);

/// The array's size is the largest width and height among its images. Colour (`srgb`) is averaged
/// as linear light, weighted by alpha where the layer is masked. `layers` may not be empty.
TextureArray build_texture_array(const std::vector<TextureLayer>& layers, bool srgb);

} // namespace ockham

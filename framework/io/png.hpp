// SPDX-License-Identifier: Apache-2.0
// PNG pictures: display-encoded (sRGB) in the file, linear floats in memory. For looking at and
// for comparing with other programs' pictures; results that are computed with belong in EXR.
#pragma once

#include "framework/core/image.hpp"

#include <cstdint>
#include <filesystem>
#include <span>

namespace ockham {

/// How linear colour is brought into [0,1] before it is encoded.
enum class Tonemap {
    none, ///< clamp
    aces, ///< Narkowicz's fit of the ACES curve, exposed by 0.6; 1 maps to 0.67
};

/// Linear colour, exposure already applied, to linear [0,1]. NaN gives 0.
float tonemap(float linear, Tonemap curve);

/// Writes R, G, B (and A, clamped and linear, with `alpha`) as 8-bit sRGB: colour times
/// 2^`exposure_ev`, tone-mapped, encoded, rounded to nearest. NaN is written as 0 and counted in
/// a warning. The file is replaced atomically and read back. Throws Error(input) if a channel is
/// missing or the file cannot be written.
void save_png8(const std::filesystem::path& path, const Image& image, float exposure_ev = 0.0f,
    Tonemap curve = Tonemap::none, bool alpha = false);

/// Writes ready-made sRGB bytes: `rgb` holds width * height * 3, top row first.
void save_png_srgb(
    const std::filesystem::path& path, int width, int height, std::span<const std::uint8_t> rgb);

/// Reads 8- and 16-bit grey, palette or colour, with or without alpha, taken as sRGB (gamma and
/// profile chunks are ignored), into linear R, G, B and, where the file has it, linear A. Throws
/// Error(input) naming the file and the reason: unreadable, not PNG, damaged (every checksum is
/// verified), or more than 2^28 pixels x channels.
Image load_png(const std::filesystem::path& path);

} // namespace ockham

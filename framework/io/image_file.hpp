// SPDX-License-Identifier: Apache-2.0
// Pictures by file name: picks EXR or PNG from the extension (in any case). What programs call;
// io/exr and io/png hold the details and the limits.
#pragma once

#include "framework/core/image.hpp"
#include "framework/io/png.hpp"

#include <filesystem>

namespace ockham {

/// Reads `.exr` or `.png` into linear channels. Throws Error(input) for anything else.
Image load_image(const std::filesystem::path& path);

/// Writes every channel, linear and unexposed, to `.exr`; or R, G, B times 2^`exposure_ev`,
/// through `curve`, to an 8-bit sRGB `.png`. Throws Error(input) for any other extension.
void save_image(const std::filesystem::path& path, const Image& image, float exposure_ev = 0.0f,
    Tonemap curve = Tonemap::none);

/// True for `.exr`, false for `.png`, in any case; throws Error(input) for any other extension.
/// Lets a program refuse an output's name before long work.
bool is_exr_path(const std::filesystem::path& path);

} // namespace ockham

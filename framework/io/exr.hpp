// SPDX-License-Identifier: Apache-2.0
// OpenEXR pictures: linear float channels, layers as `layer.channel`, text metadata. Reads what
// other programs write; writes scan lines with ZIP compression. Not for deep or subsampled data.
#pragma once

#include "framework/core/image.hpp"

#include <filesystem>

namespace ockham {

/// Writes every channel of `image` under its own name into one part, as 32-bit floats, or as
/// 16-bit with `half` (finite values beyond 65504 are clamped there, with a warning). Metadata
/// becomes string attributes. The file is replaced atomically and read back before this returns.
/// Throws Error(input) if the file cannot be written, or if a metadata key is empty or one of
/// OpenEXR's own ("channels", "type", ...).
void save_exr(const std::filesystem::path& path, const Image& image, bool half = false);

/// Reads the first part: half, float and 32-bit integer channels, in scan lines or tiles (the
/// largest level). R, G, B, A come first, the others in the file's order; string attributes
/// become metadata. The image is the data window; a warning says so where the display window
/// differs, and where further parts are ignored. Throws Error(input) naming the file and the
/// reason: unreadable, damaged, deep, subsampled, or more than 2^28 pixels x channels.
Image load_exr(const std::filesystem::path& path);

} // namespace ockham

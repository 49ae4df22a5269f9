// SPDX-License-Identifier: Apache-2.0
// Materials of isosurfaces from a JSON file: one, or one for each isovalue. Written by hand, so
// every key has a default and every mistake is named.
#pragma once

#include "framework/scene/volume_view.hpp"

#include <filesystem>
#include <vector>

namespace ockham {

/// {"base_color": [r,g,b], "opacity", "metallic", "subsurface", "specular", "roughness",
/// "specular_tint", "anisotropic", "sheen", "sheen_tint", "clearcoat", "clearcoat_gloss"}, or
/// {"surfaces": [such an object, ...]}. All in [0, 1]; at least one; their isovalues are 0. Throws
/// Error(input) naming the file, the key and what was found.
std::vector<VolumeView::Surface> load_iso_materials(const std::filesystem::path& path);

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
// Encoded pictures (PNG, JPEG) to the 8-bit images of materials. Not for results of rendering:
// those are float images of io/png and io/exr. Private to io/gltf.
#pragma once

#include "framework/scene/material.hpp"

#include <cstddef>
#include <span>

namespace ockham {

/// Decodes to RGBA, 8 bits each; the name stays empty. Throws Error(input) unless the bytes are a
/// whole picture with sides from 1 to 16384.
TextureImage decode_texture(std::span<const std::byte> encoded);

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
// Everything about one picture of a volume that its kernels share: place, light, surfaces, camera.
// Builds the VolumeFrame of shaders/shared/volume.h, in the kernels' units; pipelines upload it
// whenever something of it changes.
#pragma once

#include "framework/scene/camera.hpp"
#include "framework/scene/volume_view.hpp"
#include "framework/scene_gpu/volume_gpu.hpp"
#include "shaders/shared/volume.h"

#include <cstdint>

namespace ockham {

/// `width`, `height`: pixels. Throws Error(input) for more surfaces or planes than kernels hold, an
/// empty crop box, and numbers out of range, naming them.
shader::VolumeFrame make_volume_frame(const VolumePlace& place, const VolumeGpu& volume,
    const Camera& camera, std::uint32_t width, std::uint32_t height, const VolumeView& view);

/// Of the picture that `frame` was made for, what shows is the part of `size` pixels that begins at
/// `origin`.
void set_part(shader::VolumeFrame& frame, glm::uvec2 size, glm::uvec2 origin);

/// Sees every box that is at most as wide as the picture: from the front (-y), +z up.
Camera volume_camera();

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
// Rasterises the scene into a G-buffer of m x m samples per pixel: packed surface attributes and
// reversed depth (shaders/surface/packing.glsl). No albedo: textures wait for the shading.
#pragma once

#include "passes/surface/draw_scene.hpp"

namespace ockham {

struct GbufferParams {
    std::uint32_t width = 0, height = 0; ///< pixels
    std::uint32_t m = 1;                 ///< samples per pixel and axis, 1 ... 8
};

/// Images of (m width) x (m height) samples.
struct Gbuffer {
    ImageHandle surface; ///< rgba32ui, 16 bytes a sample; undefined where depth is 0
    ImageHandle depth;   ///< d32, 1 at the near plane, 0 = background
    ImageHandle extra;   ///< rgba32ui, only if the scene has vertex colours or two coordinate sets
};

/// Throws Error(input) where a side would exceed `max_extent` samples.
Gbuffer add_gbuffer(
    Graph& graph, const SceneInputs& in, const GbufferParams& params, std::uint32_t max_extent);

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
// Images for built-in scenes: tiling stone, brick, tiles, cloth, leaves, each a colour image and,
// where it has relief, the normal map of its height field. Called by the built-in scenes only.
#pragma once

#include "framework/scene/material.hpp"

#include <cstdint>

namespace ockham {

/// Colour (sRGB) and data images of one surface; an image without pixels is absent.
struct SurfaceImages {
    TextureImage color;
    TextureImage normal;    ///< tangent space, green up in the image
    TextureImage roughness; ///< green: roughness, blue: metallic, red: occlusion
};

/// Two-by-two cells of linear 0 and 1, `size` pixels wide; black top left.
TextureImage checker_image(int size);

SurfaceImages ashlar_images();    ///< dressed stone blocks, 2 m
SurfaceImages brick_images();     ///< bricks, 1 m
SurfaceImages limestone_images(); ///< plain stone, 1 m
SurfaceImages plaster_images();   ///< lime plaster, 2 m
SurfaceImages paving_images();    ///< stone slabs with dark insets, 2 m; with roughness
SurfaceImages quarry_images();    ///< square clay tiles, 1 m
SurfaceImages roof_images();      ///< rows of half-round roof tiles, 1 m, ridge up
SurfaceImages wood_images();      ///< planks, 1 m, grain along v
SurfaceImages cloth_images();  ///< woven stripes and lozenges in grey, to be tinted; no tiling in v
SurfaceImages sprig_images();  ///< a twig with leaves, alpha cuts it out
SurfaceImages blades_images(); ///< a tuft of grass, alpha cuts it out; its foot at v = 1
SurfaceImages meadow_images(); ///< short grass and soil, 4 m
// Grey or white, to be tinted; what matters is the relief.
SurfaceImages hammered_images(); ///< dents of a hammer, 0.5 m
SurfaceImages ripple_images();   ///< wet stone: waves down to the texel, 2 m
SurfaceImages flake_images();    ///< small facets that each lean their own way, 0.5 m

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
// Unpacks what the first sample of each pixel saw, for pictures of intermediate values. Exists only
// where somebody asks for it.
#pragma once

#include "passes/surface/gbuffer.hpp"

namespace ockham {

struct SurfaceAov {
    ImageHandle surface;  ///< rgba32f: world normal, view depth (infinite on background)
    ImageHandle material; ///< r32ui: index, or NO_MATERIAL of shaders/debug/surface_aov.h
};

/// `width`, `height`: pixels.
SurfaceAov add_surface_aov(Graph& graph, BufferHandle frame, const Gbuffer& gbuffer,
    std::uint32_t width, std::uint32_t height);

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
// Rasterises the scene, and isosurfaces that are opaque, into a G-buffer of m x m samples per
// pixel, in one of two layouts: packed surface attributes (shaders/surface/packing.glsl), or the
// ids of triangles, which kernels evaluate anew (visibility.glsl). No albedo: textures wait for the
// shading.
#pragma once

#include "passes/surface/draw_scene.hpp"
#include "passes/volume/medium_inputs.hpp"

#include <optional>
#include <string_view>
#include <vector>

namespace ockham {

enum class GbufferLayout {
    packed,     ///< as the paper: 16 bytes a sample, and depth
    visibility, ///< 4 bytes a sample; depth only while it is drawn
};

/// The part of a picture that is drawn; may change between executions.
struct ScreenTile {
    glm::ivec2 origin{0};  ///< its first pixel in the picture
    glm::uvec2 picture{0}; ///< in pixels
};

struct GbufferParams {
    std::uint32_t width = 0, height = 0; ///< pixels
    std::uint32_t m = 1;                 ///< samples per pixel and axis, 1 ... 8
    GbufferLayout layout = GbufferLayout::packed;
    bool slopes = false;              ///< packed: also what fetch_plane() needs
    const ScreenTile* tile = nullptr; ///< null: the images are the whole picture; else outlives it
    std::optional<MediumInputs> medium = {}; ///< packed: whose opaque isosurfaces are drawn as well
};

/// Images of (m width) x (m height) samples, and what their layout takes from the scene.
struct Gbuffer {
    ImageHandle surface;     ///< packed: rgba32ui, undefined where depth is 0; visibility: r32ui
    ImageHandle depth;       ///< d32, 1 at the near plane, 0 = background
    ImageHandle extra = {};  ///< packed: rgba32ui, if vertex colours or two coordinate sets exist
    ImageHandle slopes = {}; ///< packed: r32ui, on request
    GbufferLayout layout = GbufferLayout::packed;
    SceneInputs scene = {}; ///< visibility only
};

/// Throws Error(input) where a side would exceed `max_extent` samples.
Gbuffer add_gbuffer(
    Graph& graph, const SceneInputs& in, const GbufferParams& params, std::uint32_t max_extent);

/// Bytes of a sample while it is drawn.
std::uint32_t gbuffer_bytes_per_sample(const Graph& graph);

/// Declares what shaders/surface/surface_sample.glsl reads.
void read_gbuffer(PassBuilder& pass, const Gbuffer& gbuffer, Stage stage = Stage::compute);
/// `shader` with the features `mode` (or none), visibility and its data_textures, in that order.
/// For kernels that look at surfaces but not at lights.
std::string gbuffer_variant(std::string_view shader, std::string_view mode, const Gbuffer& gbuffer);
/// Of such kernels; empty for packed.
Specialization gbuffer_specialization(const Gbuffer& gbuffer);

} // namespace ockham

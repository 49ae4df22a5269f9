// SPDX-License-Identifier: Apache-2.0
// Meshes and a medium in one picture: L = L_mesh + (L_medium - (1 - T) L_mesh). The first term is
// the meshes' own picture; the second is estimated along the rays of its samples, and 0 where the
// medium is not in the way. Here: where these rays end and on what, and the sum. Called by
// pipelines; docs/passes/meshes.md.
#pragma once

#include "passes/surface/shading_inputs.hpp"

#include <cstdint>

namespace ockham {

/// "mesh_ends": r32ui, a texel for each sample of the G-buffer, by its rank in the order: where the
/// camera's ray meets a mesh, and which of the window's surfaces that is, as
/// shaders/volume/mesh_ends.comp packs them. `labels`: Clusters::labels; empty at m = 1. Kept.
ImageHandle add_mesh_ends(Graph& graph, BufferHandle frame, const Gbuffer& gbuffer,
    ImageHandle labels, const ShadingParams& params);

/// "mesh_radiance": rgba32f, a layer for each surface of a window, whose mean by coverage is the
/// picture of the meshes. Shades one sample for each surface of windows that see several. Kept.
ImageHandle add_mesh_radiance(Graph& graph, const ShadingInputs& in, ImageHandle labels,
    ImageHandle picture, const ShadingParams& params);

/// A copy of `image` for later executions, persistent; the pass is called "keep_" and that name.
ImageHandle add_kept(Graph& graph, ImageHandle image, const std::string& name);

/// How many rays each pixel has had: one of the two.
struct MeshRays {
    BufferHandle progress; ///< PathTrace::progress
    ImageHandle count;     ///< Composed::count
};

/// The picture, rgba32f: that of the meshes and its mean change by the medium, rgba32f, as large.
ImageHandle add_over_meshes(Graph& graph, const MeshInputs& meshes, ImageHandle change,
    const MeshRays& rays, std::uint32_t m);

} // namespace ockham

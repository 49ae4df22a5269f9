// SPDX-License-Identifier: Apache-2.0
// What every pass on a volume reads, and the names of shader variants that follow from it.
#pragma once

#include "framework/runtime/commands.hpp"
#include "framework/scene_gpu/volume_gpu.hpp"
#include "shaders/shared/volume.h"

#include <initializer_list>
#include <string>
#include <string_view>

namespace ockham {

/// Meshes in the medium; empty handles: there are none, or the sun casts no shadow.
struct MeshInputs {
    ImageHandle ends;     ///< add_mesh_ends()
    ImageHandle radiance; ///< add_mesh_radiance()
    ImageHandle picture;  ///< of the meshes alone, kept
    ImageHandle sun_map;  ///< add_shadow_map(), of VolumeFrame::sun_projection
    BufferHandle tree;    ///< MeshTree, nodes and triangles; empty: nothing scatters
    BufferHandle lamps;   ///< the scene's lights; empty: none of them is a point or a spot
    std::uint32_t first_lamp = 0, points = 0, spots = 0; ///< of these
};

struct MediumInputs {
    VolumeFacts facts;
    VolumeHandles handles;
    BufferHandle frame;     ///< shader::VolumeFrame
    BufferHandle ranges;    ///< vec2 per range cell: least and greatest texel value; with surfaces
    BufferHandle majorants; ///< float per range cell: greatest opacity; not where homogeneous
    bool surfaces = false;  ///< there is an isovalue
    bool opaque = false;    ///< samples of the G-buffer show the first isosurface of opacity 1
    bool translucent = false; ///< there is one of less
    bool sobol = true;        ///< samples of a pixel or cell avoid each other
    MeshInputs meshes = {};
};

/// Which of them a kernel reads; the medium itself always.
struct MediumUse {
    bool tracking = true; ///< majorants
    bool light = true;    ///< environment map
    bool surfaces = true; ///< ranges
};

/// Declares the reads under the names of shaders/volume/*.glsl.
void read_medium(PassBuilder& pass, const MediumInputs& in, const MediumUse& use = {});

/// "volume/path_trace.comp:noncaching,emission,grid,surfaces,environment_map": `mode` (may be
/// empty), then of these features those that `use` and the inputs have, in this order.
std::string medium_variant(std::string_view shader, std::string_view mode, const MediumInputs& in,
    const MediumUse& use = {});

/// Constants of kernels that draw random numbers (shaders/include/random.glsl), and look at meshes.
Specialization medium_specialization(const MediumInputs& in);

/// Declares what shaders/volume/meshes.glsl reads, where there are meshes: `camera`, where rays of
/// a camera are followed. mesh_variant() adds the feature to a name by medium_variant().
void read_meshes(PassBuilder& pass, const MediumInputs& in, bool camera);
std::string mesh_variant(std::string variant, const MediumInputs& in);
/// For kernels that follow paths: what volume/mesh_tree.glsl and volume/lamps.glsl read besides,
/// and constants.
void read_mesh_tree(PassBuilder& pass, const MediumInputs& in);
Specialization path_specialization(const MediumInputs& in);

/// Declares what shaders/volume/transmittance.glsl reads. It is there once, with and without
/// majorants and isosurfaces: what its constants switch off is bound to something else.
void read_transmittance(PassBuilder& pass, const MediumInputs& in);
Specialization transmittance_specialization(const MediumInputs& in);
/// Loop iterations of one way through the medium, at most.
std::uint32_t transmittance_iterations(const MediumInputs& in);

} // namespace ockham

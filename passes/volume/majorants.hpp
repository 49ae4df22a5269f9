// SPDX-License-Identifier: Apache-2.0
// Bounds of the field and of its opacity over cells of RANGE_CELL^3 voxels, which kernels walk to
// skip what is empty (shaders/volume/cells.glsl). Kept between executions: ranges change with the
// volume, majorants with the transfer function. Called by pipelines.
#pragma once

#include "framework/scene_gpu/volume_gpu.hpp"

namespace ockham {

/// Empty handles: nobody needs them.
struct Majorants {
    /// vec2 per cell, x fastest: least and greatest texel value among those that lookups in the
    /// cell touch.
    BufferHandle ranges;
    BufferHandle majorants; ///< float per cell: greatest opacity over its range
};

/// What has changed since the last execution; everything has before the first. Where the volume
/// has, so has the transfer function's table.
struct MajorantsChange {
    Condition volume, transfer;
};

/// `frame`: shader::VolumeFrame. `surfaces`: something looks for isovalues, and reads the ranges.
Majorants add_majorants(Graph& graph, const VolumeFacts& facts, const VolumeHandles& handles,
    BufferHandle frame, bool surfaces, const MajorantsChange& changed);

} // namespace ockham

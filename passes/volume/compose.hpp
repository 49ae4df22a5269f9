// SPDX-License-Identifier: Apache-2.0
// Composes a volume front to back along view rays, with in-scattered light from the cache and
// surfaces shaded where they are met: the picture of mode `caching`. Adds a sample per pixel each
// time, and shows the mean. Moving the camera costs a restart of this sum, not of the cache.
#pragma once

#include "passes/volume/medium_inputs.hpp"

#include <cstdint>
#include <memory>

namespace ockham {

struct ComposeInputs {
    MediumInputs medium;
    BufferHandle cache_index, cache_cells; ///< as volume/cache_lookup.glsl reads them
    /// Where the first surface is, from add_surface_depth() and for rays through pixel centres.
    /// Empty: it is found exactly, for the jittered ray.
    ImageHandle surface_depth = {};
};

struct ComposeParams {
    std::uint32_t width = 0, height = 0; ///< pixels, those of the frame
    std::uint32_t samples = 1;           ///< per pixel and execution, >= 1: a pass each
    /// Loop iterations of an invocation, >= 1; a ray that needs more goes on in the next pass.
    /// Drivers may stop eight of them, of one SIMD group, at 65,535 in all.
    std::uint32_t iterations = 8000;
    float step_voxels = 0.5f; ///< longest step, > 0
    float step_depth = 0.5f;  ///< optical depth per step, > 0; shortens steps up to 8 times
    bool jitter = true;       ///< within pixels and steps
};

struct Composed {
    ImageHandle picture; ///< rgba32f: mean radiance, mean of 1 - transmittance
    ImageHandle sum;     ///< rgba32f, persistent: sums of these over a pixel's samples
    ImageHandle count;   ///< r32ui, persistent: 2 * samples, + 1 where a ray is under way
    ImageHandle state;   ///< rgba32ui, three layers, persistent: that ray
    /// False: executions from now on take no new samples, and only end the rays under way.
    std::shared_ptr<bool> begins;
};

/// `restart`: begin anew, as when the camera or anything that is seen has changed.
Composed add_compose(
    Graph& graph, const ComposeInputs& in, const ComposeParams& params, Condition restart);

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
// The cache of global illumination in a volume: the mean radiance that arrives in each cell of a
// grid, refined by paths over as many executions as it takes, and kept while only the camera moves.
// Readers include shaders/volume/cache_lookup.glsl. docs/passes/cache.md.
#pragma once

#include "passes/volume/medium_inputs.hpp"
#include "shaders/volume/cache.h"

#include <cstdint>

namespace ockham {

enum class CacheFormat : std::uint32_t {
    fp32 = CACHE_FP32,     ///< 12 bytes a cell
    fp16 = CACHE_FP16,     ///< 8 bytes, three halves
    rgb9e5 = CACHE_RGB9E5, ///< 4 bytes, a shared exponent
};

struct CacheParams {
    std::uint32_t scale = 2; ///< voxels along a side of a cell: 1, 2 or 4
    CacheFormat format = CacheFormat::fp16;
    bool directional = false; ///< g != 0: keeps the mean direction too, 8 bytes more
    bool occlusion = true;    ///< surfaces keep light out; without it the cache ignores them
    /// Cells inside the surface get slots too (neither paths nor light), so that a change of the
    /// isovalue moves no slot, and cells show their old values until new ones are there.
    bool hold_solid = false;
    float target_error = 0.02f;           ///< relative standard error of each cell's mean, >= 0
    std::uint32_t working_set = 1u << 19; ///< cells that are refined at a time, >= 64
    std::uint32_t places = 1u << 13;      ///< for paths that the loop budget has interrupted, >= 1
    std::uint32_t paths = 8; ///< of the neediest cells in one execution: a power of two, >= 8
    std::uint32_t iterations = 20000; ///< loop budget of an invocation, >= 1
    std::uint32_t capacity = 1;       ///< cells that hold memory: CacheSize::slots
};

struct CacheSize {
    std::uint32_t cells = 0; ///< of the grid: 4 bytes each
    std::uint32_t slots = 0; ///< cells that hold memory
    std::uint32_t solid = 0; ///< of these, inside the surface
    std::uint64_t bytes = 0; ///< index, stored cells, working set, and the marks of a new layout
};

/// Counts what the cache needs for a volume, transfer function, crop and isovalue, on the device.
/// A graph takes its sizes when it is declared, and they follow from the data, so this is a small
/// graph of its own: run it before, and again whenever one of these has changed. `frame`:
/// shader::VolumeFrame. Of `params`, `capacity` is not read. Throws Error(input) for parameters out
/// of range, Error(device) for more than the device binds at a time, with the numbers.
CacheSize count_cache_cells(gpu::Device& device, const VolumeGpu& volume, const gpu::Buffer& frame,
    const CacheParams& params);

/// What has changed since the last execution. A camera move is `none`.
enum class CacheChange {
    none,
    light,   ///< light, environment, density scale, albedo, g
    surface, ///< an isovalue or its opacity
    medium,  ///< volume, transfer function, crop, clip planes: count_cache_cells() anew
};

struct Cache {
    BufferHandle index; ///< "cache_index" of readers: CacheHeader, a word per cell
    BufferHandle cells; ///< "cache_cells" of readers
    /// shader::CacheControl, persistent: the statistics. Paths, steps, and whether every cell has
    /// reached the target.
    BufferHandle control;
    BufferHandle sums;  ///< shader::CacheSum per slot of the working set
    ImageHandle counts; ///< r8ui, CACHE_SET_WIDTH wide: which bucket each of them is in
    Condition layout, clear, restart; ///< set by set_cache_change()
    bool hold_solid = false;
};

/// Declares the passes of one execution: each gives the cells that need it most up to
/// `params.paths` paths. Everything counts as changed before the first execution.
/// Throws Error(input) for parameters out of range.
Cache add_cache(Graph& graph, const MediumInputs& medium, const CacheParams& params);

/// For the next execution. What is begun anew equals a fresh cache of the same seed bit for bit.
/// After `surface` without hold_solid there may be more slots than capacity: count them, and
/// declare anew if so; cells beyond it are left out.
void set_cache_change(Executor& executor, const Cache& cache, CacheChange change);

} // namespace ockham

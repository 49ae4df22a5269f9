// SPDX-License-Identifier: Apache-2.0
// Path tracing of a volume, a fixed number of samples per pixel and execution. Paths that the
// budget of iterations leaves unfinished are stored, and go on in the next execution; nothing is
// dropped, and pictures are the same bit for bit whatever the budget is. Called by pipelines.
#pragma once

#include "passes/volume/medium_inputs.hpp"
#include "shaders/volume/path_trace.h"

#include <cstdint>
#include <memory>
#include <span>

namespace ockham {

enum class PathMode : std::uint8_t {
    path,       ///< full transport; surfaces scatter
    noncaching, ///< a surface ends the camera's ray with local shading, and later segments with 0
    gather,     ///< as noncaching, but the second collision reads the cache
};

/// Most iterations of an invocation, of all its loops. Drivers that count them stop kernels
/// silently at 65,535.
inline constexpr std::uint32_t kPathIterations = 60000;

struct PathTraceParams {
    std::uint32_t width = 0, height = 0; ///< pixels
    PathMode mode = PathMode::path;
    std::uint32_t samples_per_step = 1;         ///< per pixel and execution to begin with, >= 1
    std::uint32_t iterations = kPathIterations; ///< budget of an invocation
    bool jitter = true;                         ///< box filter over pixels; false: their centres
    bool nee = true;                       ///< --nee: an environment map is sampled at collisions
    std::uint64_t buffer_bytes = 1u << 27; ///< most that a kernel can bind of a buffer
};

/// Conditions of an execution.
struct PathTraceConditions {
    Condition restart; ///< forget all samples first
    Condition drain;   ///< take no new samples, only finish what has begun
};

/// The cache that gather reads.
struct PathCache {
    BufferHandle index, cells;
};

/// All kept between executions.
struct PathTrace {
    ImageHandle sum;         ///< rgba32f: of radiance, and of samples that met anything
    ImageHandle square;      ///< r32f: of squared luminance (Rec. 709)
    BufferHandle progress;   ///< uvec2 per pixel: samples finished, samples wanted
    BufferHandle statistics; ///< uint64[PATHS_STATISTICS]
    /// Per pixel and execution, >= 1. Its caller may change it between executions.
    std::shared_ptr<std::uint32_t> samples;
    ImageHandle radiance; ///< rgba32f, transient: mean; unbiased once no path is unfinished
};

/// Noncaching and gather have no surfaces beyond those of local shading. `cache`: gather only.
PathTrace add_path_trace(Graph& graph, const MediumInputs& in, const PathTraceParams& params,
    const PathTraceConditions& conditions, const PathCache& cache = {});

/// What PathTrace::statistics holds.
struct PathStatistics {
    std::uint64_t wanted = 0, finished = 0; ///< samples
    std::uint64_t steps = 0;                ///< tentative collisions
    std::uint64_t resumed = 0;              ///< paths stored for the next execution
    std::uint64_t truncated = 0;            ///< not finite: must be 0
    std::uint64_t clamped = 0;              ///< extinction above its majorant: must be 0
    bool drained() const { return finished == wanted; }
};
PathStatistics path_statistics(std::span<const std::byte> bytes);

} // namespace ockham

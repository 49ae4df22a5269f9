// SPDX-License-Identifier: Apache-2.0
// The back ends of adaptive shading, and how well each fills the SIMD lanes of a map of counts.
#pragma once

#include <cstdint>
#include <span>

namespace ockham {

/// How pixels of unequal counts meet lanes.
enum class Dispatch {
    loop,    ///< each invocation loops over its own pixel's samples
    buckets, ///< one indirect dispatch per count
    repack,  ///< the (pixel, sample) pairs of a tile are spread over lanes
    stencil, ///< one draw per count, stencil test
    depth,   ///< one draw per count, depth test
    sort,    ///< one dispatch over pixels sorted by count
};

inline constexpr Dispatch kDispatches[] = {Dispatch::loop, Dispatch::buckets, Dispatch::repack,
    Dispatch::stencil, Dispatch::depth, Dispatch::sort};

/// "loop", "buckets", ...: as on command lines.
const char* name_of(Dispatch dispatch);

/// Useful share of SIMD lanes, 0 ... 1, where groups of `lanes` (a multiple of 4) work as long as
/// their longest lane: `counts` of width x height pixels, row by row. Each pixel's first sample
/// counts as a full lane, for it is shaded before, alike for all.
double lane_efficiency(std::span<const float> counts, std::uint32_t width, std::uint32_t height,
    Dispatch dispatch, std::uint32_t lanes);

} // namespace ockham

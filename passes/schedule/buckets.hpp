// SPDX-License-Identifier: Apache-2.0
// Sorts items by a small count, so that each count can be worked off by its own indirect dispatch
// without divergence. Deterministic: histograms, scan and stable scatter; no atomics, no read-back.
#pragma once

#include "framework/graph/graph.hpp"

#include <cstdint>
#include <string>

namespace ockham {

struct BucketsParams {
    std::uint32_t width = 0, height = 0; ///< of the count image, each <= 65,535
    std::uint32_t bucket_count = 1;      ///< largest count, 1 ... 64
    std::string prefix = {};             ///< of the names of passes and resources
};

/// Layouts: shaders/schedule/buckets.h.
struct Buckets {
    /// Bucket[bucket_count + 1]: where each count's items stand in `list`; the last: all items of
    /// count 2 and more.
    BufferHandle table;
    BufferHandle arguments; ///< DispatchArguments for each of them, workgroups of BUCKET_GROUP
    BufferHandle list;      ///< uint[width * height]: x | y << 16, by count, then tile, then row
};

/// `sample_count`: r8ui, values 1 ... bucket_count (others are clamped).
Buckets add_buckets(Graph& graph, ImageHandle sample_count, const BucketsParams& params);

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
// Packs ranges of memory whose lifetimes are intervals of steps into as little memory as it can
// (offline dynamic storage allocation, which is NP-hard: heuristics, best of several). Called by
// place.cpp; knows nothing of graphs.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace ockham {

struct LiveRange {
    std::uint64_t bytes = 0;     ///< >= 1
    std::uint64_t alignment = 1; ///< of the offset; >= 1, any number
    std::uint32_t first = 0;     ///< inclusive steps
    std::uint32_t last = 0;
};

struct Packing {
    std::vector<std::uint64_t> offsets; ///< one per range
    std::uint64_t bytes = 0;            ///< largest end of a range
};

/// Ranges that share a step never share a byte. `ranges` must be sorted by `first`. Deterministic.
/// Up to some hundred ranges several orders are tried; of thousands, two: forward and backward in
/// time, each in little more than n log n.
Packing pack(std::span<const LiveRange> ranges);

/// The most bytes that are live in one step: no packing is smaller.
std::uint64_t live_bytes(std::span<const LiveRange> ranges);

} // namespace ockham

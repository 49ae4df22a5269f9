// SPDX-License-Identifier: Apache-2.0
// Declaration to plan: checks, culls, orders, places memory, derives barriers. A pure function of
// its arguments: no device, no globals, callable from several threads; equal input, equal plan.
#pragma once

#include "framework/graph/format.hpp"
#include "framework/graph/plan.hpp"

namespace ockham {

/// Facts of a device that shape a plan. The defaults suit planning without one.
struct Capabilities {
    std::uint64_t buffer_image_granularity = 1;
    std::uint64_t max_buffer_bytes = std::uint64_t{1} << 32;
    std::uint32_t max_image_extent = 16384;
};

struct Policy {
    /// Transient resources share memory by lifetime. Off: one range each, for debugging.
    bool alias_memory = true;
    /// 0 = no limit. A plan above it is refused with a table of what is large and why it lives.
    std::uint64_t memory_budget_bytes = 0;
};

/// Throws Error(input), starting with a stable code in brackets, that names pass and resource:
/// see docs/graph.md for the list of misuses.
Plan compile(const Declaration& declaration, const Capabilities& capabilities = {},
    const Policy& policy = {});

/// Memory that the description implies on a device without padding: texel size x extent (all mips
/// and layers), alignment 256.
MemoryNeed estimate_memory(const ResourceDecl& resource);

} // namespace ockham

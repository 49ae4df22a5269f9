// SPDX-License-Identifier: Apache-2.0
// Declaration to plan: checks, culls, orders, places memory, derives barriers. A pure function of
// its arguments: no device, no globals, callable from several threads; equal input, equal plan.
#pragma once

#include "framework/graph/format.hpp"
#include "framework/graph/plan.hpp"

#include <vector>

namespace ockham {

struct QueueFamily {
    bool graphics = true;
    bool compute = true;
    bool transfer = true;
    std::uint32_t queues = 1; ///< that may be used
};

/// Facts of a device that shape a plan. The defaults suit planning without one.
struct Capabilities {
    /// By Vulkan's index; one of them must have graphics and compute. Empty: one with one queue.
    std::vector<QueueFamily> families;
    std::uint64_t buffer_image_granularity = 1;
    std::uint64_t max_buffer_bytes = std::uint64_t{1} << 32;
    std::uint32_t max_image_extent = 16384;
    std::uint32_t max_image_layers = 2048;
    std::uint32_t max_attachment_extent = 16384;
};

/// In which order passes run, among those that their data allow.
enum class Order : std::uint8_t {
    declared, ///< as they were added
    /// Passes that need not wait for each other come together, so that one batch of barriers serves
    /// several of them.
    batched,
};

struct Policy {
    Order order = Order::declared;
    /// Order::batched only: how many more bytes may live at a time than in the declared order, as a
    /// fraction. 0: not one more; infinity: whatever gives the fewest batches.
    double batch_memory = 0;
    /// Passes that wish so run on other queues, where the device has them.
    bool async_queues = true;
    /// Transient resources share memory by lifetime. Off: one range each, for debugging.
    bool alias_memory = true;
    /// PlanCache plans anew even where it has a plan, and aborts where the two differ.
    bool paranoid = false;
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

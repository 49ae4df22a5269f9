// SPDX-License-Identifier: Apache-2.0
// What compile() decided, as plain data: order, barriers, memory, what was culled and why.
// Executed by the runtime, printed by dump, checked by tests. Knows no device.
#pragma once

#include "framework/graph/declaration.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace ockham {

/// Why a barrier exists.
enum class Hazard : std::uint8_t {
    read_after_write,
    write_after_read,
    write_after_write,
    layout,    ///< same data, other layout
    first_use, ///< content is new: from UNDEFINED, after whoever last used the memory
    /// Memory handed over from other resources. src_* are theirs, so the dependency must cover
    /// memory that was written through them, not only accesses through this one.
    alias,
    exit, ///< external resource left in the promised state
};
const char* name_of(Hazard hazard);

/// One memory dependency on one resource. Buffers ignore the layouts. Later readers in the same
/// layout wait by this barrier too: their stages and accesses are part of dst_*.
struct Barrier {
    ResourceId resource = kNone;
    Hazard hazard = Hazard::read_after_write;
    PassId from = kNone; ///< the pass waited for; kNone = before this execution
    PassId to = kNone;   ///< the first pass that waits; kNone = after the execution
    VkPipelineStageFlags2 src_stages = 0, dst_stages = 0;
    VkAccessFlags2 src_access = 0, dst_access = 0;
    VkImageLayout old_layout = VK_IMAGE_LAYOUT_UNDEFINED;
    VkImageLayout new_layout = VK_IMAGE_LAYOUT_UNDEFINED;
};

/// One pass to execute, after one batch of barriers (one vkCmdPipelineBarrier2).
struct Step {
    PassId pass = kNone;
    std::uint32_t first_barrier = 0;
    std::uint32_t barrier_count = 0;
};

/// Where a transient or persistent resource lives.
struct Placement {
    ResourceId resource = kNone;
    std::uint32_t heap = 0; ///< index into Plan::heaps
    std::uint64_t offset = 0;
    std::uint64_t bytes = 0;
    std::uint32_t first_step = 0, last_step = 0; ///< inclusive interval of steps that use it
};

struct Heap {
    std::uint32_t type_bits = 0;
    std::uint64_t bytes = 0;
    bool shared = true; ///< aliased by lifetime; else one persistent or exported resource each
};

/// What became of a pass or resource, and why, in a sentence.
struct Verdict {
    bool culled = false;
    std::string reason;
};

struct Plan {
    std::vector<Step> steps;
    std::vector<Barrier> barriers;
    /// Barriers after the last step: external resources into their exit state.
    std::uint32_t first_exit_barrier = 0;
    std::uint32_t exit_barrier_count = 0;
    std::vector<Placement> placements;
    std::vector<Heap> heaps;
    std::vector<Verdict> passes;    ///< one per declared pass
    std::vector<Verdict> resources; ///< one per declared resource
    /// State in which each resource is left; the state persistent ones are in on entry.
    std::vector<AccessState> final_states;
    /// Usage bits each resource must be created with (VkBufferUsageFlags or VkImageUsageFlags).
    std::vector<std::uint32_t> usages;

    std::uint64_t bytes_peak = 0; ///< sum of all heaps
    std::uint64_t bytes_lower_bound =
        0; ///< the largest live set in this order, persistent included
    double compile_us = 0;

    std::uint32_t batches() const; ///< steps (and the exit) that carry at least one barrier
};

} // namespace ockham

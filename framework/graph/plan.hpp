// SPDX-License-Identifier: Apache-2.0
// What compile() decided, as plain data: order, barriers, memory, what was culled and why.
// Executed by the runtime, printed by dump, checked by tests. Knows no device.
#pragma once

#include "framework/graph/declaration.hpp"

#include <cstdint>
#include <span>
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
    exit,    ///< external resource left in the promised state
    release, ///< given up by one queue family; `acquire` on the other says why
    acquire, ///< taken over from another queue family
};
const char* name_of(Hazard hazard);

/// One memory dependency on a part of one resource. Buffers ignore the layouts. Later readers in
/// the same layout wait by this barrier too: their stages and accesses are part of dst_*.
struct Barrier {
    ResourceId resource = kNone;
    Part part; ///< ends resolved, never kRest
    Hazard hazard = Hazard::read_after_write;
    PassId from = kNone; ///< the pass waited for; kNone = before this execution
    PassId to = kNone;   ///< the first pass that waits; kNone = after the execution
    VkPipelineStageFlags2 src_stages = 0, dst_stages = 0;
    VkAccessFlags2 src_access = 0, dst_access = 0;
    VkImageLayout old_layout = VK_IMAGE_LAYOUT_UNDEFINED;
    VkImageLayout new_layout = VK_IMAGE_LAYOUT_UNDEFINED;
    /// Queue families of release and acquire, else both IGNORED. A release ignores dst_*, its
    /// acquire ignores src_*, as Vulkan has it; both carry the same layouts.
    std::uint32_t src_family = VK_QUEUE_FAMILY_IGNORED;
    std::uint32_t dst_family = VK_QUEUE_FAMILY_IGNORED;

    bool operator==(const Barrier&) const = default;
};

/// One pass to execute, after one batch of barriers (one vkCmdPipelineBarrier2) and before one
/// batch of releases.
struct Step {
    PassId pass = kNone;
    std::uint32_t first_barrier = 0;
    std::uint32_t barrier_count = 0;
    std::uint32_t first_release = 0; ///< also in Plan::barriers
    std::uint32_t release_count = 0;

    bool operator==(const Step&) const = default;
};

/// A submission waits until another queue has completed `value` of its submissions of this
/// execution.
struct Wait {
    std::uint32_t queue = 0; ///< index into Plan::queues
    std::uint32_t value = 0; ///< >= 1
    VkPipelineStageFlags2 stages = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT; ///< that wait

    bool operator==(const Wait&) const = default;
};

/// Consecutive steps of one queue, submitted together: waits before the first, and signals the
/// queue's timeline after the last (its n-th submission makes it n). Everything on a queue starts
/// in submission order; the first submission of each queue in an execution also waits for all that
/// the other queues did in the execution before.
struct Submission {
    std::uint32_t queue = 0;
    std::uint32_t first_step = 0;
    std::uint32_t step_count = 0; ///< 0 only in the last, for the exit barriers
    std::uint32_t first_wait = 0;
    std::uint32_t wait_count = 0;

    bool operator==(const Submission&) const = default;
};

/// A queue that the plan uses. Queue 0 is the main one, which also executes the exit barriers.
struct PlanQueue {
    std::uint32_t family = 0; ///< index into Capabilities::families
    std::uint32_t index = 0;  ///< of the queue within its family

    bool operator==(const PlanQueue&) const = default;
};

/// Where a transient or persistent resource lives.
struct Placement {
    ResourceId resource = kNone;
    std::uint32_t heap = 0; ///< index into Plan::heaps
    std::uint64_t offset = 0;
    std::uint64_t bytes = 0;
    std::uint32_t first_step = 0, last_step = 0; ///< inclusive interval of steps that use it

    bool operator==(const Placement&) const = default;
};

struct Heap {
    std::uint32_t type_bits = 0;
    std::uint64_t bytes = 0;
    bool shared = true; ///< aliased by lifetime; else one persistent or exported resource each

    bool operator==(const Heap&) const = default;
};

/// What became of a pass or resource, and the first reason why; explain.hpp puts it into words.
struct Verdict {
    enum class Cause : std::uint8_t {
        // Kept passes: `resource` is what they write.
        read,        ///< `pass` reads it
        exported,    ///< it is exported
        persistent,  ///< the next execution finds it
        external,    ///< the caller gets it
        side_effect, ///< declared so
        // Kept resources
        used, ///< from `pass` to `last_pass`
        ring, ///< a history between two ages that are used
        // Culled ones
        unread,      ///< nothing reads `resource`
        overwritten, ///< `pass` replaces `resource` before anything reads it
        unread_too,  ///< only `pass`, culled too, reads `resource`
        writes_nothing,
        contradiction, ///< its guard is never fulfilled
        unused, ///< a resource: no live pass uses it
    };
    bool culled = false;
    Cause cause = Cause::unused;
    PassId pass = kNone;
    PassId last_pass = kNone;
    ResourceId resource = kNone;

    bool operator==(const Verdict&) const = default;
};

struct Plan {
    std::vector<PlanQueue> queues;       ///< at least one
    std::vector<Submission> submissions; ///< in an order in which they may be submitted
    std::vector<Wait> waits;
    std::vector<Step> steps; ///< in the order of the submissions
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
    /// One per declared resource: used by several queue families and kept beyond the execution, so
    /// it is created with VK_SHARING_MODE_CONCURRENT and never changes owner.
    std::vector<std::uint8_t> concurrent;

    std::uint64_t bytes_peak = 0; ///< sum of all heaps
    /// The largest live set in the order of the declaration, what is kept included: no packing of
    /// that order is smaller.
    std::uint64_t bytes_lower_bound = 0;
    double compile_us = 0; ///< time it took; no part of the plan

    std::span<const Barrier> barriers_before(const Step& step) const {
        return {barriers.data() + step.first_barrier, step.barrier_count};
    }
    std::span<const Barrier> releases_after(const Step& step) const {
        return {barriers.data() + step.first_release, step.release_count};
    }
    std::span<const Barrier> exit_barriers() const {
        return {barriers.data() + first_exit_barrier, exit_barrier_count};
    }
    std::uint32_t batches() const; ///< steps (and the exit) that carry at least one barrier
};

/// Same decisions, whatever time they took.
bool operator==(const Plan& a, const Plan& b);

} // namespace ockham

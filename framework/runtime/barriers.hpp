// SPDX-License-Identifier: Apache-2.0
// Barriers of a plan as Vulkan has them: one batch, one vkCmdPipelineBarrier2. For the runtime's
// recorders only; what to wait for is the plan's decision.
#pragma once

#include "framework/graph/plan.hpp"
#include "framework/runtime/resources.hpp"

#include <vulkan/vulkan.h>

#include <span>
#include <vector>

namespace ockham {

class BarrierBatch {
public:
    struct Options {
        /// Queue families do not exist. Releases are left out, and acquires change the layout only;
        /// the plan's waits give the rest.
        bool one_family = false;
        /// Says twice what follows from Vulkan's rules, but not for the validation layer 1.3.239:
        /// that a barrier on one resource orders the execution of everything in its stages and
        /// those logically earlier and later, and that what is available may be overwritten.
        bool spell_out = false;
    };
    BarrierBatch() = default;
    explicit BarrierBatch(const Options& options) : options_(options) {}

    void add(const Barrier& barrier, const Resource& resource);
    void record(VkCommandBuffer commands) const;

private:
    void spell_out(const Barrier& barrier);

    Options options_;
    std::vector<VkMemoryBarrier2> memory_;
    std::vector<VkBufferMemoryBarrier2> buffers_;
    std::vector<VkImageMemoryBarrier2> images_;
};

/// From everything to everything: for set-up and debugging, never in a plan.
void record_full_barrier(VkCommandBuffer commands);

} // namespace ockham

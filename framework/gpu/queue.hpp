// SPDX-License-Identifier: Apache-2.0
// Queues as data: what families can do, which queue is meant, and one submission to it. Device
// submits; the runtime fills these in.
#pragma once

#include <vulkan/vulkan.h>

#include <cstdint>
#include <span>

namespace ockham::gpu {

/// What the queues of one family can do.
struct FamilyInfo {
    bool graphics = false;
    bool compute = false;
    bool transfer = false;
    std::uint32_t queues = 0; ///< that the device has created; 0: not to be used
    std::uint32_t timestamp_bits = 0;

    bool operator==(const FamilyInfo&) const = default;
};

struct QueueId {
    std::uint32_t family = 0;
    std::uint32_t index = 0; ///< within the family, < FamilyInfo::queues

    auto operator<=>(const QueueId&) const = default;
};

/// A value of a timeline semaphore, to wait for or to signal. For a binary semaphore the value does
/// not matter.
struct TimelinePoint {
    VkSemaphore semaphore = VK_NULL_HANDLE;
    std::uint64_t value = 0;
    /// What waits for it, or what it waits for when signalled.
    VkPipelineStageFlags2 stages = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
};

struct QueueSubmission {
    QueueId queue;
    std::span<const VkCommandBuffer> commands = {};
    std::span<const TimelinePoint> waits = {};
    std::span<const TimelinePoint> signals = {};
    VkFence fence = VK_NULL_HANDLE; ///< signalled when all is done; may be null
};

} // namespace ockham::gpu

// SPDX-License-Identifier: Apache-2.0
// GPU times: a pool of timestamps, written between commands and read after the submission.
#pragma once

#include <vulkan/vulkan.h>

#include <cstdint>
#include <vector>

namespace ockham::gpu {

class Device;

class Timestamps {
public:
    /// Room for `count` >= 1 timestamps.
    Timestamps(Device& device, std::uint32_t count);
    ~Timestamps();
    Timestamps(const Timestamps&) = delete;
    Timestamps& operator=(const Timestamps&) = delete;

    /// Before timestamps `first` and on are written again; outside render passes, on a queue with
    /// compute.
    void reset(VkCommandBuffer commands, std::uint32_t first, std::uint32_t count) const;
    /// Timestamp `index`, once all commands before are done; outside render passes. On software
    /// devices a barrier of everything follows, without which lavapipe times whatever it had
    /// deferred. Not under Validation::sync, where it would hide missing barriers; times mean
    /// little there.
    void write(VkCommandBuffer commands, std::uint32_t index) const;
    /// Nanoseconds of `count` timestamps, relative to the first of them. All were written on queues
    /// of `family`, whose counters have timestamps, and the submissions that did so must be over.
    std::vector<double> read(std::uint32_t first, std::uint32_t count, std::uint32_t family) const;

private:
    Device& device_;
    VkQueryPool pool_ = VK_NULL_HANDLE;
};

} // namespace ockham::gpu

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

    /// Outside render passes, before the first write of each submission.
    void reset(VkCommandBuffer commands) const;
    /// Timestamp `index`, once all commands before are done; outside render passes. A barrier of
    /// everything follows, without which lavapipe times whatever it had deferred. Not under
    /// Validation::sync, where it would hide missing barriers; times mean little there.
    void write(VkCommandBuffer commands, std::uint32_t index) const;
    /// Nanoseconds of the timestamps of the last submission, which must be over and have written
    /// them all. Only differences mean something.
    std::vector<double> read() const;

private:
    Device& device_;
    std::uint32_t count_;
    VkQueryPool pool_ = VK_NULL_HANDLE;
};

} // namespace ockham::gpu

// SPDX-License-Identifier: Apache-2.0
// What one execution in flight has of its own: command buffers, descriptor sets, timestamps, and
// how to know that it is over. For the executor only.
#pragma once

#include "framework/gpu/descriptors.hpp"
#include "framework/gpu/timestamps.hpp"

#include <vulkan/vulkan.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace ockham {

/// Command buffers of one execution and one queue family, from a pool that is reset before the
/// next.
class CommandBuffers {
public:
    CommandBuffers(gpu::Device& device, std::uint32_t family);
    ~CommandBuffers();
    CommandBuffers(const CommandBuffers&) = delete;
    CommandBuffers& operator=(const CommandBuffers&) = delete;

    void reset();
    /// Ends the present buffer, if any, and begins another.
    VkCommandBuffer begin();
    /// Ends the present buffer and gives all since the last call.
    std::vector<VkCommandBuffer> finish();

private:
    void end();

    gpu::Device& device_;
    VkCommandPool pool_ = VK_NULL_HANDLE;
    std::vector<VkCommandBuffer> buffers_;
    std::size_t begun_ = 0;    ///< since reset()
    std::size_t finished_ = 0; ///< of these, given away
    VkCommandBuffer open_ = VK_NULL_HANDLE;
};

struct Frame {
    /// `families`: of the queues that the plan uses. `timestamps` may be 0.
    Frame(gpu::Device& device, std::span<const std::uint32_t> families, std::uint32_t timestamps);
    ~Frame();
    Frame(const Frame&) = delete;
    Frame& operator=(const Frame&) = delete;

    /// The execution that used it is over.
    void reset();
    void destroy_retired();

    gpu::Device& device;
    std::vector<std::unique_ptr<CommandBuffers>> commands; ///< by queue of the plan
    gpu::DescriptorArena descriptors;
    std::optional<gpu::Timestamps> timestamps;
    std::vector<VkFramebuffer> retired; ///< that this execution or one before may use
    std::vector<std::uint8_t> skipped;  ///< by step: a condition left it out
    bool in_flight = false;
    VkFence fence = VK_NULL_HANDLE;  ///< signalled at the end of one submission or none
    std::vector<std::uint64_t> ends; ///< else: values of the queues' timelines then
};

} // namespace ockham

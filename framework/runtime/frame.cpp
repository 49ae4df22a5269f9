// SPDX-License-Identifier: Apache-2.0
#include "framework/runtime/frame.hpp"

#include "framework/gpu/device.hpp"

namespace ockham {

CommandBuffers::CommandBuffers(gpu::Device& device, std::uint32_t family) : device_(device) {
    const VkCommandPoolCreateInfo info{
        .sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO, .queueFamilyIndex = family};
    gpu::expect(
        vkCreateCommandPool(device.handle(), &info, nullptr, &pool_), "creating a command pool");
}

CommandBuffers::~CommandBuffers() { vkDestroyCommandPool(device_.handle(), pool_, nullptr); }

void CommandBuffers::reset() {
    gpu::expect(vkResetCommandPool(device_.handle(), pool_, 0), "resetting a command pool");
    begun_ = finished_ = 0;
    open_ = VK_NULL_HANDLE; // left open by an error while recording
}

VkCommandBuffer CommandBuffers::begin() {
    end();
    if (begun_ == buffers_.size()) {
        const VkCommandBufferAllocateInfo info{
            .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
            .commandPool = pool_,
            .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
            .commandBufferCount = 1};
        VkCommandBuffer buffer = VK_NULL_HANDLE;
        gpu::expect(vkAllocateCommandBuffers(device_.handle(), &info, &buffer),
            "allocating a command buffer");
        buffers_.push_back(buffer);
    }
    open_ = buffers_[begun_++];
    const VkCommandBufferBeginInfo info{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
        .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
    gpu::expect(vkBeginCommandBuffer(open_, &info), "beginning a command buffer");
    // lavapipe skips a barrier that begins a command buffer, and then what was drawn before may
    // still be under way in memory that others take over. So something else begins it.
    if (device_.info().software) vkCmdSetLineWidth(open_, 1.0f);
    return open_;
}

std::vector<VkCommandBuffer> CommandBuffers::finish() {
    end();
    const std::span<const VkCommandBuffer> fresh(buffers_.data() + finished_, begun_ - finished_);
    finished_ = begun_;
    return {fresh.begin(), fresh.end()};
}

void CommandBuffers::end() {
    if (open_) gpu::expect(vkEndCommandBuffer(open_), "ending a command buffer");
    open_ = VK_NULL_HANDLE;
}

Frame::Frame(
    gpu::Device& owner, std::span<const std::uint32_t> families, std::uint32_t timestamp_count)
    : device(owner), descriptors(owner), ends(families.size(), 0) {
    for (const std::uint32_t family : families) {
        commands.push_back(std::make_unique<CommandBuffers>(owner, family));
    }
    if (timestamp_count > 0) timestamps.emplace(owner, timestamp_count);
    const VkFenceCreateInfo info{.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    gpu::expect(vkCreateFence(owner.handle(), &info, nullptr, &fence), "creating a fence");
}

Frame::~Frame() {
    destroy_retired();
    vkDestroyFence(device.handle(), fence, nullptr);
}

void Frame::destroy_retired() {
    for (const VkFramebuffer target : retired) {
        vkDestroyFramebuffer(device.handle(), target, nullptr);
    }
    retired.clear();
}

void Frame::reset() {
    for (const auto& of_queue : commands) of_queue->reset();
    descriptors.reset();
    destroy_retired();
}

} // namespace ockham

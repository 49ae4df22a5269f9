// SPDX-License-Identifier: Apache-2.0
// A Vulkan buffer with its memory. Holds no state: barriers are the graph's business, or
// transfer's.
#pragma once

#include "framework/gpu/memory.hpp"

#include <span>
#include <string>
#include <vector>

namespace ockham::gpu {

class Device;

struct BufferInfo {
    std::uint64_t bytes = 0; ///< >= 1
    VkBufferUsageFlags usage = 0;
    std::string name = {};
    MemoryUse memory = MemoryUse::device;
    std::vector<std::uint32_t> families = {}; ///< that share it at a time; empty: one owns it
};

class Buffer {
public:
    /// Content is undefined. Throws Error(device) naming the buffer where memory is short.
    Buffer(Device& device, const BufferInfo& info);
    /// The same on memory of somebody else, which must outlive it, at `offset` bytes inside.
    Buffer(Device& device, const BufferInfo& info, const Memory& memory, std::uint64_t offset);
    /// A buffer of somebody else, who created it as `info` says and destroys it.
    Buffer(Device& device, const BufferInfo& info, VkBuffer existing);
    ~Buffer();
    Buffer(Buffer&& other) noexcept;
    Buffer& operator=(Buffer&& other) noexcept;

    VkBuffer handle() const { return buffer_; }
    std::uint64_t bytes() const { return info_.bytes; }
    VkBufferUsageFlags usage() const { return info_.usage; }
    const std::string& name() const { return info_.name; }
    /// What the host sees; empty for MemoryUse::device.
    std::span<std::byte> mapped() const;

private:
    Buffer(Device* device, const BufferInfo& info); // no memory yet

    Device* device_ = nullptr;
    BufferInfo info_;
    VkBuffer buffer_ = VK_NULL_HANDLE;
    bool owned_ = true;
    Memory memory_;
};

/// What a buffer like this takes on this device.
VkMemoryRequirements memory_requirements(const Device& device, const BufferInfo& info);

} // namespace ockham::gpu

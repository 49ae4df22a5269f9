// SPDX-License-Identifier: Apache-2.0
#include "framework/gpu/buffer.hpp"

#include "framework/core/error.hpp"
#include "framework/gpu/device.hpp"

#include <utility>

namespace ockham::gpu {

namespace {

VkBufferCreateInfo create_info(const Device& device, const BufferInfo& info) {
    check(info.bytes > 0, "a buffer needs at least one byte");
    if (info.bytes > device.limits().buffer_bytes) {
        fail_device("buffer '{}' has {} bytes, the device allows {}", info.name, info.bytes,
            device.limits().buffer_bytes);
    }
    return {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
        .size = info.bytes,
        .usage = info.usage,
        .sharingMode =
            info.families.empty() ? VK_SHARING_MODE_EXCLUSIVE : VK_SHARING_MODE_CONCURRENT,
        .queueFamilyIndexCount = static_cast<std::uint32_t>(info.families.size()),
        .pQueueFamilyIndices = info.families.data()};
}

VkBuffer create(const Device& device, const BufferInfo& info) {
    const VkBufferCreateInfo create = create_info(device, info);
    VkBuffer buffer = VK_NULL_HANDLE;
    expect(vkCreateBuffer(device.handle(), &create, nullptr, &buffer),
        fmt::format("creating buffer '{}' of {} bytes", info.name, info.bytes));
    set_name(device, VK_OBJECT_TYPE_BUFFER, buffer, info.name);
    return buffer;
}

} // namespace

Buffer::Buffer(Device* device, const BufferInfo& info)
    : device_(device), info_(info), buffer_(create(*device, info)) {}

Buffer::Buffer(Device& device, const BufferInfo& info) : Buffer(&device, info) {
    memory_ =
        device.allocator().allocate(memory_requirements(device, info), info.memory, info.name);
    expect(vkBindBufferMemory(device.handle(), buffer_, memory_.handle(), memory_.offset()),
        fmt::format("binding memory to buffer '{}'", info.name));
}

Buffer::Buffer(Device& device, const BufferInfo& info, const Memory& memory, std::uint64_t offset)
    : Buffer(&device, info) {
    expect(vkBindBufferMemory(device.handle(), buffer_, memory.handle(), memory.offset() + offset),
        fmt::format("binding memory to buffer '{}'", info.name));
}

Buffer::Buffer(Device& device, const BufferInfo& info, VkBuffer existing)
    : device_(&device), info_(info), buffer_(existing), owned_(false) {}

Buffer::~Buffer() {
    if (buffer_ && owned_) vkDestroyBuffer(device_->handle(), buffer_, nullptr);
}

Buffer::Buffer(Buffer&& other) noexcept
    : device_(other.device_), info_(std::move(other.info_)),
      buffer_(std::exchange(other.buffer_, VK_NULL_HANDLE)), owned_(other.owned_),
      memory_(std::move(other.memory_)) {}

Buffer& Buffer::operator=(Buffer&& other) noexcept {
    std::swap(device_, other.device_);
    std::swap(info_, other.info_);
    std::swap(buffer_, other.buffer_);
    std::swap(owned_, other.owned_);
    std::swap(memory_, other.memory_);
    return *this;
}

std::span<std::byte> Buffer::mapped() const {
    if (info_.memory == MemoryUse::device) return {};
    return {memory_.mapped(), static_cast<std::size_t>(info_.bytes)};
}

VkMemoryRequirements memory_requirements(const Device& device, const BufferInfo& info) {
    const VkBufferCreateInfo create = create_info(device, info);
    const VkDeviceBufferMemoryRequirements query{
        .sType = VK_STRUCTURE_TYPE_DEVICE_BUFFER_MEMORY_REQUIREMENTS, .pCreateInfo = &create};
    VkMemoryRequirements2 result{.sType = VK_STRUCTURE_TYPE_MEMORY_REQUIREMENTS_2};
    vkGetDeviceBufferMemoryRequirements(device.handle(), &query, &result);
    return result.memoryRequirements;
}

} // namespace ockham::gpu

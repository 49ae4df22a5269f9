// SPDX-License-Identifier: Apache-2.0
// Device memory in blocks: small requests share 64 MiB blocks, large ones get their own. Counts
// what is in use against a budget. Buffer, Image and the runtime's heaps allocate here; nobody
// else.
#pragma once

#include <vulkan/vulkan.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string_view>
#include <vector>

namespace ockham::gpu {

/// device: fastest for shaders. upload: mapped, written by the host. readback: mapped, cached.
enum class MemoryUse { device, upload, readback };

/// Where blocks of memory come from: an embedder's own allocator. Both or neither are set; they are
/// called under the allocator's lock, for 64 MiB or the size of something larger than half of that.
/// Each block is a VkDeviceMemory of its own and is given unmapped: Ockham maps what the host uses,
/// and gives it back unmapped.
struct MemoryHook {
    std::function<VkResult(const VkMemoryAllocateInfo& info, VkDeviceMemory& memory)> allocate = {};
    std::function<void(VkDeviceMemory memory)> free = {};
};

class Allocator;
struct MemoryBlock;

/// A piece of memory, given back when destroyed. Empty by default.
class Memory {
public:
    Memory() = default;
    ~Memory();
    Memory(Memory&& other) noexcept;
    Memory& operator=(Memory&& other) noexcept;

    VkDeviceMemory handle() const;
    std::uint64_t offset() const { return offset_; }
    std::uint64_t bytes() const { return bytes_; }
    std::uint32_t type() const; ///< index of the memory type
    /// Where the host sees it; null for MemoryUse::device. Coherent: no flush is needed.
    std::byte* mapped() const;

private:
    friend class Allocator;
    Allocator* allocator_ = nullptr;
    MemoryBlock* block_ = nullptr;
    std::uint64_t offset_ = 0;
    std::uint64_t bytes_ = 0;
};

/// Safe to call from several threads.
class Allocator {
public:
    static constexpr std::uint64_t kBlockBytes = std::uint64_t{64} << 20;

    /// `budget_bytes` 0 = no limit. `hook` empty: vkAllocateMemory.
    Allocator(VkPhysicalDevice physical, VkDevice device, std::uint64_t budget_bytes,
        MemoryHook hook = {});
    ~Allocator();

    /// Throws Error(device) naming `name` with the numbers where budget or device is exhausted, or
    /// where no memory type fits.
    Memory allocate(const VkMemoryRequirements& requirements, MemoryUse use, std::string_view name);

    std::uint64_t bytes_used() const;     ///< sum of the pieces handed out
    std::uint64_t bytes_reserved() const; ///< sum of the blocks behind them
    std::uint64_t budget_bytes() const { return budget_bytes_; }

private:
    friend class Memory;
    void release(Memory& memory);
    void free(const MemoryBlock& block) const;
    std::uint32_t memory_type(std::uint32_t bits, MemoryUse use, std::string_view name) const;
    MemoryBlock& add_block(
        std::uint32_t type, MemoryUse use, std::uint64_t bytes, std::string_view name);

    VkDevice device_;
    MemoryHook hook_;
    VkPhysicalDeviceMemoryProperties properties_{};
    std::uint64_t granularity_ = 1;
    std::uint64_t budget_bytes_;
    std::uint64_t bytes_used_ = 0;
    std::uint64_t bytes_reserved_ = 0;
    mutable std::mutex mutex_;
    std::vector<std::unique_ptr<MemoryBlock>> blocks_;
};

} // namespace ockham::gpu

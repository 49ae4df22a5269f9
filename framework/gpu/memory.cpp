// SPDX-License-Identifier: Apache-2.0
#include "framework/gpu/memory.hpp"

#include "framework/core/error.hpp"
#include "framework/core/memory_table.hpp"
#include "framework/gpu/debug.hpp"
#include "framework/gpu/device_lost.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace ockham::gpu {

struct MemoryBlock {
    VkDeviceMemory memory = VK_NULL_HANDLE;
    std::uint64_t bytes = 0;
    std::uint32_t type = 0;
    MemoryUse use = MemoryUse::device;
    std::byte* mapped = nullptr;
    std::map<std::uint64_t, std::uint64_t> free; ///< offset -> bytes; neighbours are merged
    std::map<std::uint64_t, MemoryRow> pieces;   ///< by offset: what is handed out
};

namespace {

std::uint64_t align_up(std::uint64_t value, std::uint64_t alignment) {
    return (value + alignment - 1) / alignment * alignment;
}

double mib(std::uint64_t bytes) { return static_cast<double>(bytes) / (1 << 20); }

std::string table_of(const std::vector<std::unique_ptr<MemoryBlock>>& blocks) {
    std::vector<MemoryRow> rows;
    for (const auto& block : blocks)
        for (const auto& [offset, piece] : block->pieces) rows.push_back(piece);
    return rows.empty() ? "" : "\nIn use on the device:" + memory_table(std::move(rows));
}

/// What a piece of memory is for, in the table.
const char* purpose_of(MemoryUse use) {
    return use == MemoryUse::device   ? "for the device alone"
           : use == MemoryUse::upload ? "written by the host"
                                      : "read by the host";
}

} // namespace

Memory::~Memory() {
    if (allocator_) allocator_->release(*this);
}

Memory::Memory(Memory&& other) noexcept
    : allocator_(std::exchange(other.allocator_, nullptr)), block_(other.block_),
      offset_(other.offset_), bytes_(other.bytes_) {}

Memory& Memory::operator=(Memory&& other) noexcept {
    std::swap(allocator_, other.allocator_);
    std::swap(block_, other.block_);
    std::swap(offset_, other.offset_);
    std::swap(bytes_, other.bytes_);
    return *this;
}

VkDeviceMemory Memory::handle() const { return block_->memory; }
std::uint32_t Memory::type() const { return block_->type; }
std::byte* Memory::mapped() const { return block_->mapped ? block_->mapped + offset_ : nullptr; }

Allocator::Allocator(
    VkPhysicalDevice physical, VkDevice device, std::uint64_t budget_bytes, MemoryHook hook)
    : device_(device), hook_(std::move(hook)), budget_bytes_(budget_bytes) {
    check(!hook_.allocate == !hook_.free, "a memory hook needs both of its functions");
    vkGetPhysicalDeviceMemoryProperties(physical, &properties_);
    VkPhysicalDeviceProperties properties;
    vkGetPhysicalDeviceProperties(physical, &properties);
    granularity_ = std::max<std::uint64_t>(properties.limits.bufferImageGranularity, 1);
}

Allocator::~Allocator() { check(blocks_.empty(), "memory outlives its device"); }

std::uint64_t Allocator::bytes_used() const {
    const std::lock_guard lock(mutex_);
    return bytes_used_;
}

std::uint64_t Allocator::bytes_reserved() const {
    const std::lock_guard lock(mutex_);
    return bytes_reserved_;
}

std::uint32_t Allocator::memory_type(
    std::uint32_t bits, MemoryUse use, std::string_view name) const {
    constexpr VkMemoryPropertyFlags host =
        VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    const VkMemoryPropertyFlags needed = use == MemoryUse::device ? 0 : host;
    VkMemoryPropertyFlags wanted = needed;
    if (use == MemoryUse::device) wanted |= VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
    if (use == MemoryUse::readback) wanted |= VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
    for (const VkMemoryPropertyFlags flags : {wanted, needed}) {
        for (std::uint32_t i = 0; i < properties_.memoryTypeCount; ++i) {
            const bool allowed = bits >> i & 1;
            if (allowed && (properties_.memoryTypes[i].propertyFlags & flags) == flags) return i;
        }
    }
    fail_device("no memory type of this device fits '{}' (allowed types {:#x}, {})", name, bits,
        needed ? "host visible and coherent" : "any property");
}

MemoryBlock& Allocator::add_block(
    std::uint32_t type, MemoryUse use, std::uint64_t bytes, std::string_view name) {
    const VkMemoryAllocateInfo info{.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
        .allocationSize = bytes,
        .memoryTypeIndex = type};
    auto block = std::make_unique<MemoryBlock>();
    block->bytes = bytes;
    block->type = type;
    block->use = use;
    block->free.emplace(0, bytes);
    try {
        expect(hook_.allocate ? hook_.allocate(info, block->memory)
                              : vkAllocateMemory(device_, &info, nullptr, &block->memory),
            fmt::format("allocating {:.1f} MiB of GPU memory for '{}' (in use: {:.1f} MiB)",
                mib(bytes), name, mib(bytes_used_)));
    } catch (const DeviceLost&) {
        throw;
    } catch (const Error& error) {
        throw Error(error.kind(), error.what() + table_of(blocks_));
    }
    if (use != MemoryUse::device) {
        void* mapped = nullptr;
        const VkResult result = vkMapMemory(device_, block->memory, 0, VK_WHOLE_SIZE, 0, &mapped);
        if (result != VK_SUCCESS) free(*block);
        expect(result, fmt::format("mapping {:.1f} MiB for '{}'", mib(bytes), name));
        block->mapped = static_cast<std::byte*>(mapped);
    }
    bytes_reserved_ += bytes;
    blocks_.push_back(std::move(block));
    return *blocks_.back();
}

Memory Allocator::allocate(
    const VkMemoryRequirements& requirements, MemoryUse use, std::string_view name) {
    const std::lock_guard lock(mutex_);
    // Whole granules, so that buffers and images may be neighbours.
    const std::uint64_t alignment = std::max(requirements.alignment, granularity_);
    const std::uint64_t bytes = align_up(requirements.size, granularity_);
    if (budget_bytes_ && bytes_used_ + bytes > budget_bytes_) {
        fail_device("'{}' needs {:.1f} MiB of GPU memory, but of the budget of {:.1f} MiB already "
                    "{:.1f} MiB are in use; raise --memory-budget or ask for less{}",
            name, mib(bytes), mib(budget_bytes_), mib(bytes_used_), table_of(blocks_));
    }
    const std::uint32_t type = memory_type(requirements.memoryTypeBits, use, name);

    Memory result;
    const auto take = [&](MemoryBlock& block) {
        // Best fit, so that large ranges survive.
        auto best = block.free.end();
        for (auto range = block.free.begin(); range != block.free.end(); ++range) {
            const std::uint64_t offset = align_up(range->first, alignment);
            const bool fits = offset + bytes <= range->first + range->second;
            if (fits && (best == block.free.end() || range->second < best->second)) best = range;
        }
        if (best == block.free.end()) return false;
        const auto [start, length] = *best;
        const std::uint64_t offset = align_up(start, alignment);
        block.free.erase(best);
        if (offset > start) block.free.emplace(start, offset - start);
        if (offset + bytes < start + length) {
            block.free.emplace(offset + bytes, start + length - offset - bytes);
        }
        result.allocator_ = this;
        result.block_ = &block;
        result.offset_ = offset;
        result.bytes_ = bytes;
        block.pieces[offset] = {bytes, std::string(name), purpose_of(use)};
        bytes_used_ += bytes;
        return true;
    };
    const bool dedicated = bytes > kBlockBytes / 2;
    if (!dedicated) {
        for (const auto& block : blocks_) {
            if (block->type == type && block->use == use && take(*block)) return result;
        }
    }
    const bool taken = take(add_block(type, use, dedicated ? bytes : kBlockBytes, name));
    check(taken, "a fresh memory block is too small");
    return result;
}

void Allocator::free(const MemoryBlock& block) const {
    if (hook_.free) {
        if (block.mapped) vkUnmapMemory(device_, block.memory);
        hook_.free(block.memory);
    } else {
        vkFreeMemory(device_, block.memory, nullptr);
    }
}

void Allocator::release(Memory& memory) {
    const std::lock_guard lock(mutex_);
    MemoryBlock& block = *memory.block_;
    block.pieces.erase(memory.offset_);
    auto range = block.free.emplace(memory.offset_, memory.bytes_).first;
    const auto next = std::next(range);
    if (next != block.free.end() && range->first + range->second == next->first) {
        range->second += next->second;
        block.free.erase(next);
    }
    if (range != block.free.begin()) {
        const auto previous = std::prev(range);
        if (previous->first + previous->second == range->first) {
            previous->second += range->second;
            block.free.erase(range);
        }
    }
    bytes_used_ -= memory.bytes_;
    if (block.free.size() == 1 && block.free.begin()->second == block.bytes) {
        bytes_reserved_ -= block.bytes;
        free(block);
        std::erase_if(blocks_, [&](const auto& other) { return other.get() == &block; });
    }
    memory.allocator_ = nullptr;
}

} // namespace ockham::gpu

// SPDX-License-Identifier: Apache-2.0
#include "framework/runtime/barriers.hpp"

#include "framework/gpu/buffer.hpp"
#include "framework/gpu/image.hpp"

#include <algorithm>

namespace ockham {

void BarrierBatch::add(const Barrier& barrier, const Resource& resource) {
    const bool one_family = options_.one_family;
    if (one_family && barrier.hazard == Hazard::release) return;
    const std::uint32_t src_family = one_family ? VK_QUEUE_FAMILY_IGNORED : barrier.src_family;
    const std::uint32_t dst_family = one_family ? VK_QUEUE_FAMILY_IGNORED : barrier.dst_family;
    VkAccessFlags2 dst_access = barrier.dst_access;
    if (options_.spell_out) {
        spell_out(barrier);
        const bool writes = barrier.src_access != 0 || barrier.old_layout != barrier.new_layout;
        if (writes && barrier.dst_stages != 0) dst_access |= VK_ACCESS_2_MEMORY_WRITE_BIT;
    }
    if (barrier.hazard == Hazard::alias) {
        // The memory was written through another resource, which a barrier on this one does not
        // cover.
        memory_.push_back({.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
            .srcStageMask = barrier.src_stages,
            .srcAccessMask = barrier.src_access,
            .dstStageMask = barrier.dst_stages,
            .dstAccessMask = dst_access});
    }
    if (resource.buffer) {
        // Up to the end of the real buffer, which may be a little longer than what is declared.
        const bool to_the_end = barrier.part.offset + barrier.part.bytes >= resource.bytes;
        buffers_.push_back({.sType = VK_STRUCTURE_TYPE_BUFFER_MEMORY_BARRIER_2,
            .srcStageMask = barrier.src_stages,
            .srcAccessMask = barrier.src_access,
            .dstStageMask = barrier.dst_stages,
            .dstAccessMask = dst_access,
            .srcQueueFamilyIndex = src_family,
            .dstQueueFamilyIndex = dst_family,
            .buffer = resource.buffer->handle(),
            .offset = barrier.part.offset,
            .size = to_the_end ? VK_WHOLE_SIZE : barrier.part.bytes});
    } else {
        images_.push_back({.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
            .srcStageMask = barrier.src_stages,
            .srcAccessMask = barrier.src_access,
            .dstStageMask = barrier.dst_stages,
            .dstAccessMask = dst_access,
            .oldLayout = barrier.old_layout,
            .newLayout = barrier.new_layout,
            .srcQueueFamilyIndex = src_family,
            .dstQueueFamilyIndex = dst_family,
            .image = resource.image->handle(),
            .subresourceRange = resource.image->subresources(range_of(barrier.part))});
    }
}

void BarrierBatch::spell_out(const Barrier& barrier) {
    if (barrier.src_stages == 0 || barrier.dst_stages == 0) return;
    const auto same = [&](const VkMemoryBarrier2& known) {
        return known.srcStageMask == barrier.src_stages && known.dstStageMask == barrier.dst_stages;
    };
    if (std::ranges::any_of(memory_, same)) return;
    memory_.push_back({.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
        .srcStageMask = barrier.src_stages,
        .dstStageMask = barrier.dst_stages});
}

void BarrierBatch::record(VkCommandBuffer commands) const {
    if (buffers_.empty() && images_.empty()) return;
    const VkDependencyInfo info{.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
        .memoryBarrierCount = static_cast<std::uint32_t>(memory_.size()),
        .pMemoryBarriers = memory_.data(),
        .bufferMemoryBarrierCount = static_cast<std::uint32_t>(buffers_.size()),
        .pBufferMemoryBarriers = buffers_.data(),
        .imageMemoryBarrierCount = static_cast<std::uint32_t>(images_.size()),
        .pImageMemoryBarriers = images_.data()};
    vkCmdPipelineBarrier2(commands, &info);
}

void record_full_barrier(VkCommandBuffer commands) {
    const VkMemoryBarrier2 all{.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
        .srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
        .srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT,
        .dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
        .dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT};
    const VkDependencyInfo info{.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
        .memoryBarrierCount = 1,
        .pMemoryBarriers = &all};
    vkCmdPipelineBarrier2(commands, &info);
}

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
#include "framework/runtime/barriers.hpp"

#include "framework/gpu/buffer.hpp"
#include "framework/gpu/image.hpp"

#include <algorithm>
#include <array>

namespace ockham {

namespace {

/// A draw passes through these in this order.
constexpr std::array<VkPipelineStageFlags2, 8> kDrawStages{VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT,
    VK_PIPELINE_STAGE_2_INDEX_INPUT_BIT, VK_PIPELINE_STAGE_2_VERTEX_ATTRIBUTE_INPUT_BIT,
    VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT, VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT,
    VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT, VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT,
    VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT};

/// What must be over when these stages are. (A dispatch reads its arguments first, too.)
VkPipelineStageFlags2 with_earlier(VkPipelineStageFlags2 stages) {
    if (stages & VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT)
        stages |= VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT;
    VkPipelineStageFlags2 earlier = 0;
    for (const VkPipelineStageFlags2 stage : kDrawStages) {
        earlier |= stage;
        if (stages & stage) stages |= earlier;
    }
    return stages;
}

/// What cannot begin before these stages do.
VkPipelineStageFlags2 with_later(VkPipelineStageFlags2 stages) {
    const VkPipelineStageFlags2 given = stages;
    for (std::size_t i = 1; i < kDrawStages.size(); ++i)
        if (stages & kDrawStages[i - 1]) stages |= kDrawStages[i];
    if (given & VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT)
        stages |= VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT;
    return stages;
}

} // namespace

void BarrierBatch::add(const Barrier& barrier, const Resource& resource) {
    const bool one_family = options_.one_family;
    if (one_family && barrier.hazard == Hazard::release) return;
    const std::uint32_t src_family = one_family ? VK_QUEUE_FAMILY_IGNORED : barrier.src_family;
    const std::uint32_t dst_family = one_family ? VK_QUEUE_FAMILY_IGNORED : barrier.dst_family;
    VkAccessFlags2 src_access = barrier.src_access, dst_access = barrier.dst_access;
    if (options_.spell_out) {
        spell_out(barrier);
        if (barrier.src_stages != 0) src_access |= VK_ACCESS_2_MEMORY_WRITE_BIT;
        if (barrier.dst_stages != 0) dst_access |= VK_ACCESS_2_MEMORY_WRITE_BIT;
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
            .srcAccessMask = src_access,
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
            .srcAccessMask = src_access,
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
    const VkPipelineStageFlags2 src = with_earlier(barrier.src_stages);
    const VkPipelineStageFlags2 dst = with_later(barrier.dst_stages);
    const auto same = [&](const VkMemoryBarrier2& known) {
        return known.srcStageMask == src && known.dstStageMask == dst;
    };
    if (std::ranges::any_of(memory_, same)) return;
    memory_.push_back({.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
        .srcStageMask = src,
        .dstStageMask = dst,
        .dstAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT});
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

// SPDX-License-Identifier: Apache-2.0
#include "framework/gpu/timestamps.hpp"

#include "framework/gpu/device.hpp"

namespace ockham::gpu {

Timestamps::Timestamps(Device& device, std::uint32_t count) : device_(device) {
    const VkQueryPoolCreateInfo info{.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
        .queryType = VK_QUERY_TYPE_TIMESTAMP,
        .queryCount = count};
    expect(vkCreateQueryPool(device.handle(), &info, nullptr, &pool_), "creating timestamps");
}

Timestamps::~Timestamps() { vkDestroyQueryPool(device_.handle(), pool_, nullptr); }

void Timestamps::reset(VkCommandBuffer commands, std::uint32_t first, std::uint32_t count) const {
    vkCmdResetQueryPool(commands, pool_, first, count);
}

void Timestamps::write(VkCommandBuffer commands, std::uint32_t index) const {
    vkCmdWriteTimestamp2(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, pool_, index);
    if (!device_.info().software || device_.validation() == Validation::sync) return;
    const VkMemoryBarrier2 everything{.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
        .srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
        .srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT,
        .dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
        .dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT};
    const VkDependencyInfo dependency{.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
        .memoryBarrierCount = 1,
        .pMemoryBarriers = &everything};
    vkCmdPipelineBarrier2(commands, &dependency);
}

std::vector<double> Timestamps::read(
    std::uint32_t first, std::uint32_t count, std::uint32_t family) const {
    std::vector<std::uint64_t> ticks(count);
    expect(vkGetQueryPoolResults(device_.handle(), pool_, first, count,
               ticks.size() * sizeof(ticks[0]), ticks.data(), sizeof(ticks[0]),
               VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT),
        "reading timestamps");
    const std::uint32_t bits = device_.families()[family].timestamp_bits;
    const std::uint64_t mask = bits >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << bits) - 1;
    // Relative to the first, so that doubles lose nothing and a wrapped counter is no jump.
    std::vector<double> nanoseconds(count);
    for (std::uint32_t i = 0; i < count; ++i) {
        nanoseconds[i] = static_cast<double>((ticks[i] - ticks[0]) & mask) *
                         device_.limits().timestamp_period_ns;
    }
    return nanoseconds;
}

} // namespace ockham::gpu

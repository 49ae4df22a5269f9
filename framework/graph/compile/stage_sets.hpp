// SPDX-License-Identifier: Apache-2.0
// Pipeline stages as small numbers, and sets of them as bits: what prune() reckons with. For
// prune.cpp only.
#pragma once

#include "framework/graph/access.hpp"

#include <array>
#include <bit>
#include <cstdint>

namespace ockham {

/// A set of stages, one bit each.
using Stages = std::uint16_t;

/// In an order in which none is logically earlier than one before it in the same pipeline.
inline constexpr std::array<VkPipelineStageFlags2, 11> kStages{
    VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT, VK_PIPELINE_STAGE_2_INDEX_INPUT_BIT,
    VK_PIPELINE_STAGE_2_VERTEX_ATTRIBUTE_INPUT_BIT, VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT,
    VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT, VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT,
    VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT, VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
    VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
    VK_PIPELINE_STAGE_2_HOST_BIT};
/// Indices of some; kOther stands for stages that are not in the list.
inline constexpr std::uint32_t kComputeStage = 8, kHostStage = 10, kOtherStage = 11;
/// Stages, and padding to a power of two.
inline constexpr std::uint32_t kStageRow = 16;

/// Calls visit(index) for each stage of the set.
template <class Visit>
void each_stage(std::uint32_t stages, Visit visit) {
    for (; stages; stages &= stages - 1)
        visit(static_cast<std::uint32_t>(std::countr_zero(stages)));
}

inline Stages stages_of(VkPipelineStageFlags2 flags) {
    // Indexed by the bit of Vulkan's flag.
    constexpr auto index_of = [] {
        std::array<std::uint8_t, 64> index{};
        index.fill(kOtherStage);
        for (std::uint8_t i = 0; i < kStages.size(); ++i)
            index[static_cast<std::size_t>(std::countr_zero(kStages[i]))] = i;
        return index;
    }();
    constexpr Stages all = (1u << (kOtherStage + 1)) - 1;
    if (flags & VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT) return all & ~(1u << kHostStage);
    Stages stages = 0;
    for (; flags; flags &= flags - 1)
        stages |=
            static_cast<Stages>(1u << index_of[static_cast<std::size_t>(std::countr_zero(flags))]);
    return stages;
}

inline VkPipelineStageFlags2 flags_of(Stages stages) {
    VkPipelineStageFlags2 flags = 0;
    for (std::uint32_t i = 0; i < kStages.size(); ++i)
        if (stages >> i & 1) flags |= kStages[i];
    return flags;
}

/// Per stage: it and those logically earlier in its pipelines. Execution scopes include them.
/// https://docs.vulkan.org/spec/latest/chapters/synchronization.html
inline constexpr auto kEarlierStages = [] {
    std::array<Stages, kStageRow> sets{};
    for (std::uint32_t i = 0; i < kStageRow; ++i) sets[i] = static_cast<Stages>(1u << i);
    for (std::uint32_t i = 1; i < kComputeStage; ++i) sets[i] |= static_cast<Stages>(sets[i] - 1);
    sets[kComputeStage] |= 1;
    return sets;
}();
/// Per stage: it and those logically later.
inline constexpr auto kLaterStages = [] {
    std::array<Stages, kStageRow> sets{};
    for (std::uint32_t i = 0; i < kStageRow; ++i)
        for (std::uint32_t k = 0; k < kStageRow; ++k)
            if (kEarlierStages[k] >> i & 1) sets[i] |= static_cast<Stages>(1u << k);
    return sets;
}();

/// The union of `sets` over the stages.
inline Stages with(const std::array<Stages, kStageRow>& sets, Stages stages) {
    Stages all = stages;
    each_stage(stages, [&](std::uint32_t i) { all |= sets[i]; });
    return all;
}

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/words.hpp"

#include <fmt/format.h>

#include <span>
#include <utility>

namespace ockham {

namespace {

using Names = std::span<const std::pair<std::uint64_t, const char*>>;

/// "compute+fragment"; bits without a name in hexadecimal.
std::string join_flags(std::uint64_t flags, Names names) {
    std::string text;
    for (const auto& [bits, name] : names) {
        if ((flags & bits) != bits) continue;
        flags &= ~bits;
        if (!text.empty()) text += '+';
        text += name;
    }
    if (flags) text += fmt::format("{}{:#x}", text.empty() ? "" : "+", flags);
    return text.empty() ? "none" : text;
}

} // namespace

std::string stages_text(VkPipelineStageFlags2 stages) {
    static constexpr std::pair<std::uint64_t, const char*> names[] = {
        {VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, "all"},
        {VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT, "indirect"},
        {VK_PIPELINE_STAGE_2_VERTEX_ATTRIBUTE_INPUT_BIT, "vertex_input"},
        {VK_PIPELINE_STAGE_2_INDEX_INPUT_BIT, "index_input"},
        {VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT, "vertex"},
        {VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT, "fragment"},
        {VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT,
            "depth_tests"},
        {VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT, "color_output"},
        {VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, "compute"},
        {VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, "transfer"},
        {VK_PIPELINE_STAGE_2_HOST_BIT, "host"},
    };
    return join_flags(stages, names);
}

std::string access_text(VkAccessFlags2 access) {
    static constexpr std::pair<std::uint64_t, const char*> names[] = {
        {VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT, "indirect_read"},
        {VK_ACCESS_2_VERTEX_ATTRIBUTE_READ_BIT, "vertex_read"},
        {VK_ACCESS_2_INDEX_READ_BIT, "index_read"},
        {VK_ACCESS_2_UNIFORM_READ_BIT, "uniform_read"},
        {VK_ACCESS_2_SHADER_SAMPLED_READ_BIT, "sampled_read"},
        {VK_ACCESS_2_SHADER_STORAGE_READ_BIT, "storage_read"},
        {VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT, "storage_write"},
        {VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT, "color_read"},
        {VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT, "color_write"},
        {VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT, "depth_read"},
        {VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT, "depth_write"},
        {VK_ACCESS_2_TRANSFER_READ_BIT, "transfer_read"},
        {VK_ACCESS_2_TRANSFER_WRITE_BIT, "transfer_write"},
        {VK_ACCESS_2_HOST_READ_BIT, "host_read"},
        {VK_ACCESS_2_HOST_WRITE_BIT, "host_write"},
        {VK_ACCESS_2_MEMORY_READ_BIT, "memory_read"},
        {VK_ACCESS_2_MEMORY_WRITE_BIT, "memory_write"},
    };
    return join_flags(access, names);
}

std::string layout_text(VkImageLayout layout) {
    switch (layout) {
    case VK_IMAGE_LAYOUT_UNDEFINED:
        return "undefined";
    case VK_IMAGE_LAYOUT_GENERAL:
        return "general";
    case VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL:
        return "color";
    case VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL:
        return "depth";
    case VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL:
        return "read_only";
    case VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL:
        return "transfer_src";
    case VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL:
        return "transfer_dst";
    case VK_IMAGE_LAYOUT_PRESENT_SRC_KHR:
        return "present";
    default:
        return fmt::format("layout_{}", static_cast<int>(layout));
    }
}

std::string size_text(std::uint64_t bytes) {
    const auto value = static_cast<double>(bytes);
    if (bytes < 1024) return fmt::format("{} B", bytes);
    if (bytes < 1024 * 1024) return fmt::format("{:.1f} KiB", value / 1024);
    return fmt::format("{:.1f} MiB", value / (1024 * 1024));
}

} // namespace ockham

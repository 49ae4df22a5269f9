// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/explain/words.hpp"

#include "framework/graph/format.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

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

/// "mip 3", "mips 3-5"; empty for all of them.
std::string range_text(
    const char* what, std::uint64_t first, std::uint64_t count, std::uint64_t all) {
    if (count == all) return {};
    if (count == 1) return fmt::format("{} {}", what, first);
    return fmt::format("{}s {}-{}", what, first, first + count - 1);
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

std::string content_text(const ResourceDecl& resource) {
    if (resource.kind == ResourceKind::buffer) return fmt::format("{} B", resource.buffer.bytes);
    const ImageDesc& image = resource.image;
    std::string text = fmt::format("{}x{}", image.width, image.height);
    if (image.depth > 1) text += fmt::format("x{}", image.depth);
    if (image.layers > 1) text += fmt::format(" {} layers", image.layers);
    if (image.mips > 1) text += fmt::format(" {} mips", image.mips);
    return fmt::format("{} {}", text, format_text(image.format));
}

std::string part_text(const ResourceDecl& resource, const Part& part) {
    if (resource.kind == ResourceKind::buffer)
        return range_text("byte", part.offset, part.bytes, resource.buffer.bytes);
    const std::string mips = range_text("mip", part.first_mip, part.mips, resource.image.mips);
    const std::string layers =
        range_text("layer", part.first_layer, part.layers, resource.image.layers);
    return mips + (mips.empty() || layers.empty() ? "" : ", ") + layers;
}

std::string part_of_text(const ResourceDecl& resource, const Part& part) {
    const std::string text = part_text(resource, part);
    return fmt::format("{}{}'{}'", text, text.empty() ? "" : " of ", resource.name);
}

std::string guard_text(const Declaration& declaration, GuardId guard) {
    std::vector<std::string> terms;
    bool first_wanted = true;
    for (; guard != kNone; guard = declaration.guards[guard].parent) {
        const Guard& term = declaration.guards[guard];
        first_wanted = term.wanted;
        terms.push_back(fmt::format("{} '{}'", term.wanted ? "where" : "unless",
            declaration.conditions[term.condition].name));
    }
    std::reverse(terms.begin(), terms.end());
    return terms.empty() ? "" : (first_wanted ? "only " : "") + list_text(terms);
}

std::string list_text(std::span<const std::string> items) {
    if (items.empty()) return {};
    if (items.size() == 1) return items[0];
    return fmt::format("{} and {}", fmt::join(items.first(items.size() - 1), ", "), items.back());
}

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
// How a pass touches a resource, and what that means to Vulkan: stages, access bits, layout.
// One table, read by the compiler, the runtime and the dumps. Enums only, no Vulkan functions.
#pragma once

#include <vulkan/vulkan_core.h>

#include <array>
#include <cstddef>
#include <cstdint>

namespace ockham {

enum class Access : std::uint8_t {
    sampled,            ///< image through a sampler or texelFetch
    storage_read,       ///< storage buffer or image, read only
    storage_write,      ///< storage buffer or image; earlier content is lost to the graph
    storage_read_write, ///< storage buffer or image, keeps earlier content
    uniform,            ///< uniform buffer
    indirect,           ///< arguments of an indirect dispatch or draw
    vertex,             ///< vertex buffer
    index,              ///< index buffer
    color_attachment,   ///< written by a raster pass
    depth_attachment,   ///< tested and written by a raster pass
    transfer_read,      ///< source of a copy
    transfer_write,     ///< destination of a copy, fill or clear; the rest keeps its content
    host_read,          ///< read by the host after the execution
};

/// Which programmable stage uses it; `fixed` where the access itself says (attachments, copies).
enum class Stage : std::uint8_t { compute, vertex, fragment, fixed };

/// The Vulkan meaning of one access; the state that it leaves a resource in.
struct AccessState {
    VkPipelineStageFlags2 stages = VK_PIPELINE_STAGE_2_NONE;
    VkAccessFlags2 access = VK_ACCESS_2_NONE;
    VkImageLayout layout = VK_IMAGE_LAYOUT_UNDEFINED; ///< images only
    /// External resources only: who owns it. IGNORED: whichever queue family uses it.
    std::uint32_t queue_family = VK_QUEUE_FAMILY_IGNORED;

    bool operator==(const AccessState&) const = default;
};

/// One row per Access, in the enum's order. Stages of 0: the shader stage that uses it.
struct AccessRow {
    const char* name;
    bool reads, writes;
    VkPipelineStageFlags2 stages;
    VkAccessFlags2 access;
    VkImageLayout layout;
    VkBufferUsageFlags buffer_usage;
    VkImageUsageFlags image_usage;
};

inline constexpr VkPipelineStageFlags2 kDepthTestStages =
    VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT;

inline constexpr std::array<AccessRow, 13> kAccessRows{{
    {"sampled", true, false, 0, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT,
        VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, 0, VK_IMAGE_USAGE_SAMPLED_BIT},
    {"storage_read", true, false, 0, VK_ACCESS_2_SHADER_STORAGE_READ_BIT, VK_IMAGE_LAYOUT_GENERAL,
        VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, VK_IMAGE_USAGE_STORAGE_BIT},
    {"storage_write", false, true, 0, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT, VK_IMAGE_LAYOUT_GENERAL,
        VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, VK_IMAGE_USAGE_STORAGE_BIT},
    {"storage_read_write", true, true, 0,
        VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
        VK_IMAGE_LAYOUT_GENERAL, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, VK_IMAGE_USAGE_STORAGE_BIT},
    {"uniform", true, false, 0, VK_ACCESS_2_UNIFORM_READ_BIT, VK_IMAGE_LAYOUT_UNDEFINED,
        VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, 0},
    {"indirect", true, false, VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT,
        VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT, VK_IMAGE_LAYOUT_UNDEFINED,
        VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT, 0},
    {"vertex", true, false, VK_PIPELINE_STAGE_2_VERTEX_ATTRIBUTE_INPUT_BIT,
        VK_ACCESS_2_VERTEX_ATTRIBUTE_READ_BIT, VK_IMAGE_LAYOUT_UNDEFINED,
        VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, 0},
    {"index", true, false, VK_PIPELINE_STAGE_2_INDEX_INPUT_BIT, VK_ACCESS_2_INDEX_READ_BIT,
        VK_IMAGE_LAYOUT_UNDEFINED, VK_BUFFER_USAGE_INDEX_BUFFER_BIT, 0},
    {"color_attachment", false, true, VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
        VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT,
        VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, 0, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT},
    {"depth_attachment", true, true, kDepthTestStages,
        VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT |
            VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT,
        VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL, 0,
        VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT},
    {"transfer_read", true, false, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
        VK_ACCESS_2_TRANSFER_READ_BIT, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
        VK_BUFFER_USAGE_TRANSFER_SRC_BIT, VK_IMAGE_USAGE_TRANSFER_SRC_BIT},
    {"transfer_write", false, true, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
        VK_ACCESS_2_TRANSFER_WRITE_BIT, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
        VK_BUFFER_USAGE_TRANSFER_DST_BIT, VK_IMAGE_USAGE_TRANSFER_DST_BIT},
    {"host_read", true, false, VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT,
        VK_IMAGE_LAYOUT_GENERAL, 0, 0},
}};

inline const AccessRow& row_of(Access access) {
    return kAccessRows[static_cast<std::size_t>(access)];
}
inline VkPipelineStageFlags2 stages_of(Stage stage) {
    constexpr std::array<VkPipelineStageFlags2, 4> stages{VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
        VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT, VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT,
        VK_PIPELINE_STAGE_2_NONE};
    return stages[static_cast<std::size_t>(stage)];
}
inline AccessState state_of(Access access, Stage stage) {
    const AccessRow& row = row_of(access);
    return {row.stages ? row.stages : stages_of(stage), row.access, row.layout};
}
/// Sees earlier content (depth_attachment and read_write included).
inline bool reads(Access access) { return row_of(access).reads; }
/// Changes content.
inline bool writes(Access access) { return row_of(access).writes; }
/// Made by a shader, so it has a stage and a binding name.
inline bool in_shader(Access access) { return row_of(access).stages == 0; }
/// Usage bits that the resource must be created with for this access.
inline VkBufferUsageFlags buffer_usage(Access access) { return row_of(access).buffer_usage; }
inline VkImageUsageFlags image_usage(Access access) { return row_of(access).image_usage; }
const char* name_of(Access access);
const char* name_of(Stage stage);

} // namespace ockham

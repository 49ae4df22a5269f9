// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/access.hpp"

#include "framework/core/error.hpp"

#include <array>

namespace ockham {

namespace {

/// One row per Access, in the enum's order. Stages of 0: the shader stage that uses it.
struct Row {
    const char* name;
    bool reads, writes;
    VkPipelineStageFlags2 stages;
    VkAccessFlags2 access;
    VkImageLayout layout;
    VkBufferUsageFlags buffer_usage;
    VkImageUsageFlags image_usage;
};

constexpr VkPipelineStageFlags2 kDepthTests =
    VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT;

constexpr std::array<Row, 13> kRows{{
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
    {"depth_attachment", true, true, kDepthTests,
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

const Row& row(Access access) { return kRows[static_cast<std::size_t>(access)]; }

constexpr VkPipelineStageFlags2 stage_bit(Stage stage) {
    switch (stage) {
    case Stage::compute:
        return VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT;
    case Stage::vertex:
        return VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT;
    case Stage::fragment:
        return VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT;
    case Stage::fixed:
        break;
    }
    return VK_PIPELINE_STAGE_2_NONE;
}

} // namespace

AccessState state_of(Access access, Stage stage) {
    const Row& r = row(access);
    return {r.stages ? r.stages : stage_bit(stage), r.access, r.layout};
}

bool reads(Access access) { return row(access).reads; }
bool writes(Access access) { return row(access).writes; }
bool in_shader(Access access) { return row(access).stages == 0; }
VkBufferUsageFlags buffer_usage(Access access) { return row(access).buffer_usage; }
VkImageUsageFlags image_usage(Access access) { return row(access).image_usage; }
const char* name_of(Access access) { return row(access).name; }

const char* name_of(Stage stage) {
    constexpr std::array<const char*, 4> names{"compute", "vertex", "fragment", "fixed"};
    return names[static_cast<std::size_t>(stage)];
}

} // namespace ockham

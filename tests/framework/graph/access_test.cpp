// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/access.hpp"

#include <gtest/gtest.h>

namespace ockham {
namespace {

TEST(Access, ShaderAccessesTakeTheStageGiven) {
    EXPECT_EQ(state_of(Access::sampled, Stage::fragment),
        (AccessState{VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT,
            VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL}));
    EXPECT_EQ(state_of(Access::storage_read, Stage::vertex),
        (AccessState{VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_READ_BIT,
            VK_IMAGE_LAYOUT_GENERAL}));
    EXPECT_EQ(state_of(Access::storage_write, Stage::compute),
        (AccessState{VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
            VK_IMAGE_LAYOUT_GENERAL}));
    EXPECT_EQ(state_of(Access::storage_read_write, Stage::compute),
        (AccessState{VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
            VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
            VK_IMAGE_LAYOUT_GENERAL}));
    EXPECT_EQ(state_of(Access::uniform, Stage::compute).access, VK_ACCESS_2_UNIFORM_READ_BIT);
}

TEST(Access, FixedAccessesIgnoreTheStageGiven) {
    for (const Stage stage : {Stage::compute, Stage::vertex, Stage::fragment, Stage::fixed}) {
        EXPECT_EQ(state_of(Access::indirect, stage).stages, VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT);
        EXPECT_EQ(state_of(Access::indirect, stage).access, VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT);
        EXPECT_EQ(
            state_of(Access::vertex, stage).stages, VK_PIPELINE_STAGE_2_VERTEX_ATTRIBUTE_INPUT_BIT);
        EXPECT_EQ(state_of(Access::index, stage).stages, VK_PIPELINE_STAGE_2_INDEX_INPUT_BIT);
        EXPECT_EQ(state_of(Access::color_attachment, stage),
            (AccessState{VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
                VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT,
                VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL}));
        EXPECT_EQ(state_of(Access::depth_attachment, stage),
            (AccessState{VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT |
                             VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT,
                VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT |
                    VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT,
                VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL}));
        EXPECT_EQ(state_of(Access::transfer_read, stage),
            (AccessState{VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_READ_BIT,
                VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL}));
        EXPECT_EQ(state_of(Access::transfer_write, stage),
            (AccessState{VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
                VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL}));
        EXPECT_EQ(state_of(Access::host_read, stage).stages, VK_PIPELINE_STAGE_2_HOST_BIT);
        EXPECT_EQ(state_of(Access::host_read, stage).access, VK_ACCESS_2_HOST_READ_BIT);
    }
}

TEST(Access, ReadsAndWrites) {
    for (const Access access :
        {Access::sampled, Access::storage_read, Access::uniform, Access::indirect, Access::vertex,
            Access::index, Access::transfer_read, Access::host_read}) {
        EXPECT_TRUE(reads(access)) << name_of(access);
        EXPECT_FALSE(writes(access)) << name_of(access);
    }
    for (const Access access :
        {Access::storage_write, Access::color_attachment, Access::transfer_write}) {
        EXPECT_FALSE(reads(access)) << name_of(access);
        EXPECT_TRUE(writes(access)) << name_of(access);
    }
    for (const Access access : {Access::storage_read_write, Access::depth_attachment}) {
        EXPECT_TRUE(reads(access)) << name_of(access);
        EXPECT_TRUE(writes(access)) << name_of(access);
    }
}

TEST(Access, UsageBits) {
    EXPECT_EQ(buffer_usage(Access::indirect), VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT);
    EXPECT_EQ(buffer_usage(Access::storage_read), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    EXPECT_EQ(buffer_usage(Access::transfer_write), VK_BUFFER_USAGE_TRANSFER_DST_BIT);
    EXPECT_EQ(buffer_usage(Access::sampled), 0u);
    EXPECT_EQ(image_usage(Access::sampled), VK_IMAGE_USAGE_SAMPLED_BIT);
    EXPECT_EQ(image_usage(Access::storage_write), VK_IMAGE_USAGE_STORAGE_BIT);
    EXPECT_EQ(image_usage(Access::depth_attachment), VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT);
    EXPECT_EQ(image_usage(Access::indirect), 0u);
}

} // namespace
} // namespace ockham

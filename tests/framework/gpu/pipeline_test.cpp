// SPDX-License-Identifier: Apache-2.0
// Pipelines by shader name, their layouts, and the cache on disk.
#include "framework/core/file.hpp"
#include "framework/gpu/pipeline.hpp"
#include "tests/support/gpu_fixture.hpp"

#include <unistd.h>

#include <algorithm>
#include <filesystem>

namespace ockham::gpu {
namespace {

using test::error_of;

class PipelineTest : public test::GpuTest {
protected:
    void SetUp() override {
        folder_ = std::filesystem::temp_directory_path() /
                  ("ockham_pipeline_test_" + std::to_string(getpid()));
        std::filesystem::remove_all(folder_);
    }
    void TearDown() override {
        std::filesystem::remove_all(folder_);
        GpuTest::TearDown();
    }
    std::filesystem::path folder_;
};

TEST_F(PipelineTest, AreMadeOncePerSpecialization) {
    Pipelines& pipelines = device().pipelines();
    const Pipeline& first = pipelines.compute("test/reflect.comp", {{5, 8}});
    EXPECT_EQ(first.local_size, (std::array<std::uint32_t, 3>{8, 4, 1}));
    const std::size_t count = pipelines.count();
    EXPECT_EQ(&pipelines.compute("test/reflect.comp", {{5, 8}}), &first);
    EXPECT_EQ(pipelines.count(), count);
    EXPECT_NE(&pipelines.compute("test/reflect.comp", {{5, 16}}), &first);
    EXPECT_EQ(pipelines.count(), count + 1);
    EXPECT_EQ(first.layout->push_bytes, 64u);
    ASSERT_EQ(first.layout->sets.size(), 2u);
    EXPECT_EQ(first.layout->pushes_set_0, device().pushes_descriptors());
    EXPECT_TRUE(std::ranges::is_sorted(first.layout->slots, {},
        [](const auto& slot) { return std::pair(slot.binding.set, slot.binding.binding); }));
}

TEST_F(PipelineTest, RasterStagesShareALayout) {
    const std::vector<Attachment> attachments{
        {VK_FORMAT_R8G8B8A8_UNORM, VK_ATTACHMENT_LOAD_OP_CLEAR, false}};
    Pipelines& pipelines = device().pipelines();
    const Pipeline& pipeline = pipelines.raster(
        {.vertex_shader = "test/pass.vert", .fragment_shader = "test/pass.frag"}, attachments);
    ASSERT_EQ(pipeline.layout->slots.size(), 2u);
    EXPECT_EQ(pipeline.layout->slots[0].stages, VkShaderStageFlags{VK_SHADER_STAGE_VERTEX_BIT});
    EXPECT_EQ(pipeline.layout->slots[1].stages, VkShaderStageFlags{VK_SHADER_STAGE_FRAGMENT_BIT});
    const std::string text = error_of([&] {
        pipelines.raster(
            {.vertex_shader = "test/pass.vert", .fragment_shader = "test/other.frag"}, attachments);
    });
    for (const char* part : {"test/pass.vert", "test/other.frag", "'heights'", "'colors'"}) {
        EXPECT_NE(text.find(part), std::string::npos) << text;
    }
}

TEST_F(PipelineTest, WrongStagesAreRefused) {
    Pipelines& pipelines = device().pipelines();
    const std::string text = error_of([&] { pipelines.compute("test/pass.vert", {}); });
    EXPECT_NE(text.find("'test/pass.vert' is a vertex shader"), std::string::npos) << text;
}

TEST_F(PipelineTest, TheCacheIsWrittenAndReadBack) {
    std::filesystem::path file;
    for (int run = 0; run < 2; ++run) {
        Device local({.cache_dir = folder_});
        file = local.pipelines().cache_file();
        EXPECT_EQ(file.parent_path(), folder_);
        local.pipelines().compute("test/reflect.comp:small,no_push", {});
    }
    ASSERT_TRUE(std::filesystem::exists(file));
    EXPECT_GE(std::filesystem::file_size(file), 32u); // at least the header
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_), {}), 1);
}

TEST_F(PipelineTest, AForeignCacheIsIgnoredAndReplaced) {
    std::filesystem::path file;
    {
        Device local({.cache_dir = folder_});
        file = local.pipelines().cache_file();
    }
    for (const std::string_view garbage : {std::string_view("short"),
             std::string_view("forty bytes of text are no pipeline cache")}) {
        write_text(file, garbage);
        Device local({.validation = Validation::core, .cache_dir = folder_});
        local.pipelines().compute("test/reflect.comp:small,no_push", {});
        EXPECT_EQ(local.validation_log().count(), 0u);
    }
    EXPECT_NE(read_text(file).substr(0, 5), "forty");
}

TEST_F(PipelineTest, AnUnwritableCacheIsNoError) {
    write_text(folder_, "a file where the folder should be");
    Device local({.cache_dir = folder_});
    local.pipelines().compute("test/reflect.comp:small,no_push", {});
}

} // namespace
} // namespace ockham::gpu

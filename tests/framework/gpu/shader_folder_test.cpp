// SPDX-License-Identifier: Apache-2.0
// Hot reload as programs see it: shaders change between executions of one graph, break and are
// mended, and results follow; what does not fit leaves everything as it was.
#include "framework/core/error.hpp"
#include "framework/core/file.hpp"
#include "framework/core/log.hpp"
#include "framework/core/timer.hpp"
#include "framework/gpu/pipeline.hpp"
#include "framework/gpu/shader_folder.hpp"
#include "framework/runtime/commands.hpp"
#include "tests/support/gpu_fixture.hpp"

#include <unistd.h>

#include <memory>
#include <mutex>
#include <optional>

namespace ockham::gpu {
namespace {

namespace fs = std::filesystem;

/// test/reload.comp with another body of main(), more declarations, or other sizes.
std::string reload_comp(std::string_view main, std::string_view declarations = "",
    std::string_view push = "uint bias;", int local_size = 8) {
    return fmt::format(
        "#version 460\n"
        "#extension GL_GOOGLE_include_directive : require\n"
        "#extension GL_EXT_scalar_block_layout : require\n"
        "#include \"test/reload.glsl\"\n"
        "layout(constant_id = 0) const uint scale = 1;\n"
        "layout(local_size_x = {}) in;\n"
        "layout(push_constant, scalar) uniform Push {{ {} }} push;\n"
        "layout(binding = 3, scalar) writeonly buffer Result {{ uint values[]; }} result;\n"
        "{}\n"
        "void main() {{ {} }}\n",
        local_size, push, declarations, main);
}

const std::string kNumber = "uint number() { return 1; }\n";
const std::string kSame = "result.values[gl_GlobalInvocationID.x] = scale * number() + push.bias;";

class ShaderFolderTest : public test::GpuTest {
protected:
    ShaderFolderTest()
        : folder_(fs::temp_directory_path() / fmt::format("ockham_shader_folder.{}", ::getpid())),
          device_({.validation = Validation::sync}) {
        fs::create_directories(folder_ / "test");
        log::set_sink([this](log::Level level, std::string_view text) {
            const std::lock_guard lock(mutex_);
            (level == log::Level::error ? errors_ : infos_) += std::string(text) + "\n";
        });
    }
    ~ShaderFolderTest() override {
        log::set_sink({});
        fs::remove_all(folder_);
    }
    void TearDown() override {
        for (const std::string& message : device_.validation_messages()) ADD_FAILURE() << message;
        EXPECT_EQ(errors_, "");
    }

    void write(const fs::path& path, std::string_view text) { write_text(folder_ / path, text); }
    void watch() { device_.pipelines().reload_from(std::make_unique<ShaderFolder>(folder_)); }

    /// Reloads, executes, and returns what every invocation wrote; 0 if they differ.
    std::uint32_t execute(std::uint32_t scale = 1) {
        if (!executor_ || scale != scale_) {
            Graph graph("reload");
            BufferHandle result = graph.create_buffer("result", {.bytes = 64});
            PassBuilder pass = graph.add_compute_pass("write");
            result = pass.write("result", result);
            pass.record([this](Commands& commands) {
                const std::uint32_t bias = 100;
                commands.dispatch_over({.shader = "test/reload.comp",
                                           .specialization = {{0, scale_}},
                                           .push = as_push(bias)},
                    {16, 1, 1});
            });
            graph.export_resource(result, "read by the test");
            scale_ = scale;
            result_ = result;
            executor_.emplace(device_, std::move(graph));
        }
        device_.pipelines().reload();
        executor_->execute();
        const auto values = test::read_as<std::uint32_t>(*executor_, result_);
        for (const std::uint32_t value : values) {
            if (value != values.front()) return 0;
        }
        return values.front();
    }

    /// What was logged as errors since the last call.
    std::string take_errors() { return std::exchange(errors_, ""); }
    void expect_error(const std::vector<std::string>& parts) {
        const std::string text = take_errors();
        for (const std::string& part : parts) {
            EXPECT_NE(text.find(part), std::string::npos) << "'" << part << "' in: " << text;
        }
    }

    fs::path folder_;
    Device device_;
    std::mutex mutex_;
    std::string errors_, infos_;
    std::uint32_t scale_ = 1;
    BufferHandle result_;
    std::optional<Executor> executor_;
};

TEST_F(ShaderFolderTest, AChangeIsSeenBetweenExecutions) {
    watch();
    EXPECT_EQ(execute(), 101u); // the folder is empty: the embedded one
    write("test/reload.glsl", kNumber);
    write("test/reload.comp", reload_comp("result.values[gl_GlobalInvocationID.x] = 7;"));
    EXPECT_EQ(execute(), 7u);
    EXPECT_NE(infos_.find("reloaded shaders: test/reload.comp\n"), std::string::npos) << infos_;
    write("test/reload.comp", reload_comp("result.values[gl_GlobalInvocationID.x] = 8 + scale;"));
    EXPECT_EQ(execute(), 9u);
    EXPECT_EQ(execute(3), 11u); // a pipeline that was not there yet
    fs::remove(folder_ / "test/reload.comp");
    EXPECT_EQ(execute(3), 103u); // the embedded one again
}

TEST_F(ShaderFolderTest, TheFolderCountsFromTheFirstExecution) {
    write("test/reload.glsl", kNumber);
    write("test/reload.comp", reload_comp("result.values[gl_GlobalInvocationID.x] = 7;"));
    watch();
    EXPECT_EQ(execute(), 7u);
}

TEST_F(ShaderFolderTest, PipelinesMadeBeforeTheFolderFollowItToo) {
    EXPECT_EQ(execute(), 101u);
    write("test/reload.glsl", kNumber);
    write("test/reload.comp", reload_comp("result.values[gl_GlobalInvocationID.x] = 7;"));
    EXPECT_EQ(execute(), 101u);
    watch();
    EXPECT_EQ(execute(), 7u);
}

TEST_F(ShaderFolderTest, ABrokenShaderLeavesTheLastGoodOne) {
    watch();
    write("test/reload.glsl", kNumber);
    write("test/reload.comp", reload_comp("result.values[gl_GlobalInvocationID.x] = 7;"));
    EXPECT_EQ(execute(), 7u);
    write("test/reload.comp", reload_comp("result.values[gl_GlobalInvocationID.x] = nothing;"));
    EXPECT_EQ(execute(), 7u);
    expect_error({(folder_ / "test/reload.comp").string() + ":10: 'nothing'", "those in use stay"});
    EXPECT_EQ(execute(), 7u);
    EXPECT_EQ(take_errors(), ""); // said once
    write("test/reload.comp", reload_comp("result.values[gl_GlobalInvocationID.x] = 9;"));
    EXPECT_EQ(execute(), 9u);
}

TEST_F(ShaderFolderTest, BrokenFromTheStartMeansTheEmbeddedOne) {
    write("test/reload.comp", "garbage");
    watch();
    EXPECT_EQ(execute(), 101u);
    expect_error({(folder_ / "test/reload.comp").string() + ":1: "});
    write("test/reload.glsl", kNumber);
    write("test/reload.comp", reload_comp(kSame));
    EXPECT_EQ(execute(), 101u);
    EXPECT_NE(infos_.find("reloaded"), std::string::npos); // mended, though with the same result
}

TEST_F(ShaderFolderTest, IncludedFilesAreWatched) {
    write("test/reload.comp", reload_comp(kSame));
    watch();
    EXPECT_EQ(execute(), 101u);
    expect_error({":4: ", "test/reload.glsl", "is not in"});
    write("test/reload.glsl", "uint number() { return 50; }\n"); // was looked for in vain
    EXPECT_EQ(execute(), 150u);
    write("test/reload.glsl", "uint number() { return other(); }\n");
    EXPECT_EQ(execute(), 150u);
    expect_error({(folder_ / "test/reload.glsl").string() + ":1: 'other'"});
    write("test/reload.glsl", "uint number() { return 60; }\n");
    EXPECT_EQ(execute(), 160u);
}

TEST_F(ShaderFolderTest, AShaderThatTheDeclarationDoesNotFitIsRefused) {
    write("test/reload.glsl", kNumber);
    watch();
    const std::string seven = "result.values[gl_GlobalInvocationID.x] = 7;";
    // Another binding.
    write("test/reload.comp",
        reload_comp("result.values[gl_GlobalInvocationID.x] = more.values[0];",
            "layout(binding = 1) readonly buffer More { uint values[]; } more;"));
    EXPECT_EQ(execute(), 101u);
    expect_error({"'test/reload.comp'", "'more'", "rebuild"});
    // The same binding, which it now reads.
    write("test/reload.comp", "#version 460\n#extension GL_EXT_scalar_block_layout : require\n"
                              "layout(local_size_x = 8) in;\n"
                              "layout(push_constant, scalar) uniform Push { uint bias; } push;\n"
                              "layout(binding = 0) buffer Result { uint values[]; } result;\n"
                              "layout(constant_id = 0) const uint scale = 1;\n"
                              "void main() { result.values[gl_GlobalInvocationID.x] += scale; }\n");
    EXPECT_EQ(execute(), 101u);
    expect_error({"'result'", "direction"});
    // Other push constants.
    write("test/reload.comp", reload_comp(seven, "", "uint bias; uint more;"));
    EXPECT_EQ(execute(), 101u);
    expect_error({"'test/reload.comp'", "8 bytes of push constants, but 4"});
    // A workgroup that is too large; a constant that is gone.
    write("test/reload.comp", reload_comp(seven, "", "uint bias;", 512));
    EXPECT_EQ(execute(), 101u);
    expect_error({"512"});
    // Another workgroup, and a binding renumbered, are fine.
    write("test/reload.comp", reload_comp(seven, "", "uint bias;", 16));
    EXPECT_EQ(execute(), 7u);
}

TEST_F(ShaderFolderTest, AShaderThatOtherPipelinesCannotUseIsGivenUp) {
    write("test/reload.glsl", kNumber);
    watch();
    const std::string seven = "result.values[gl_GlobalInvocationID.x] = 7;";
    std::string text = reload_comp(seven);
    const std::string size = "layout(local_size_x = 8) in;";
    write("test/reload.comp",
        text.replace(text.find(size), size.size(), "layout(local_size_x_id = 0) in;"));
    EXPECT_EQ(execute(8), 7u);
    EXPECT_EQ(execute(1000), 1100u); // 1000 invocations are too many
    expect_error({"'test/reload.comp'", "1000", "given up"});
    write("test/reload.comp", reload_comp(seven));
    EXPECT_EQ(execute(1000), 7u);
}

TEST_F(ShaderFolderTest, ABrokenShaderDoesNotHoldUpOthersAtTheStart) {
    write("test/reload.comp", "garbage");
    write("test/pass.vert", "#version 460\nvoid main() { gl_Position = vec4(1.0); }\n");
    watch();
    EXPECT_EQ(execute(), 101u);
    expect_error({"reload.comp:1: "});
    const RasterState state{.vertex_shader = "test/pass.vert", .depth_test = false};
    EXPECT_TRUE(device_.pipelines().raster(state, {}).layout->slots.empty()); // of the folder
    EXPECT_NE(infos_.find("reloaded shaders: test/pass.vert\n"), std::string::npos) << infos_;
    EXPECT_EQ(execute(), 101u); // and the error is not repeated
}

TEST_F(ShaderFolderTest, StagesAreTakenUpTogetherOrNotAtAll) {
    const fs::path source = fs::path(OCKHAM_SOURCE) / "tests/framework/gpu/shaders/test";
    const std::string vertex = read_text(source / "pass.vert");
    const std::string fragment = read_text(source / "pass.frag");
    const auto with = [](std::string text, const std::string& line) {
        return text.insert(text.rfind('}'), line);
    };
    write("test/pass.vert", vertex);
    write("test/pass.frag", fragment);
    watch();
    Pipelines& pipelines = device_.pipelines();
    const auto get = [&] {
        pipelines.reload();
        return &pipelines.raster(
            {.vertex_shader = "test/pass.vert", .fragment_shader = "test/pass.frag"},
            {{VK_FORMAT_R8G8B8A8_UNORM, VK_ATTACHMENT_LOAD_OP_CLEAR, false}});
    };
    const Pipeline* const first = get();
    EXPECT_EQ(infos_.find("reloaded"), std::string::npos); // the same words
    write("test/pass.vert", with(vertex, "gl_Position.x += 1.0;\n"));
    write("test/pass.frag", with(fragment, "nothing;\n"));
    EXPECT_EQ(get(), first);
    expect_error({"pass.frag:", "'nothing'"});
    write("test/pass.frag", fragment); // mended: only the vertex shader is another
    const Pipeline* const second = get();
    EXPECT_NE(second, first);
    EXPECT_EQ(get(), second);
    EXPECT_EQ(pipelines.count(), 1u);
    EXPECT_NE(first->handle, second->handle); // the old one still lives
}

TEST_F(ShaderFolderTest, LookingForChangesIsCheap) {
    write("test/reload.glsl", kNumber);
    write("test/reload.comp", reload_comp(kSame));
    watch();
    EXPECT_EQ(execute(), 101u);
    const Timer timer;
    for (int i = 0; i < 1000; ++i) device_.pipelines().reload();
    const double microseconds = timer.milliseconds();
    fmt::print("one look at two files takes {:.1f} us\n", microseconds);
    EXPECT_LT(microseconds, 1000);
}

TEST(ShaderFolder, MustBeAFolder) {
    for (const char* path : {"/nonexistent/folder", "/dev/null", ""}) {
        try {
            const ShaderFolder folder(path);
            ADD_FAILURE() << path;
        } catch (const Error& error) {
            EXPECT_EQ(error.kind(), ErrorKind::input);
            EXPECT_NE(std::string(error.what()).find(fmt::format("'{}'", path)), std::string::npos);
        }
    }
}

} // namespace
} // namespace ockham::gpu

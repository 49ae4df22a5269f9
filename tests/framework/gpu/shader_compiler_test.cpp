// SPDX-License-Identifier: Apache-2.0
// GLSL compiled in process: the words of the build for every shader of the tree, one line per
// mistake, and nothing read outside of the folder.
#include "framework/core/error.hpp"
#include "framework/core/file.hpp"
#include "framework/gpu/shader.hpp"
#include "framework/gpu/shader_compiler.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <ctime>
#include <set>

namespace ockham::gpu {
namespace {

namespace fs = std::filesystem;

class ShaderCompilerTest : public testing::Test {
protected:
    ShaderCompilerTest()
        : base_(fs::temp_directory_path() / fmt::format("ockham_shader_compiler.{}", ::getpid())),
          folder_(base_ / "shaders") {
        fs::create_directories(folder_ / "test");
    }
    ~ShaderCompilerTest() override { fs::remove_all(base_); }

    void write(const fs::path& path, std::string_view text) { write_text(folder_ / path, text); }
    /// A compute shader with `lines` from line 4 on.
    void write_shader(const fs::path& path, std::string_view lines) {
        write(path, fmt::format("#version 460\n"
                                "#extension GL_GOOGLE_include_directive : require\n"
                                "layout(local_size_x = 8) in;\n"
                                "{}\n",
                        lines));
    }
    /// The Error's text; "" if there is none.
    std::string error_of(std::string_view name) {
        try {
            compile_shader(folder_, name);
        } catch (const Error& error) {
            EXPECT_EQ(error.kind(), ErrorKind::input);
            return error.what();
        }
        return "";
    }
    void expect_error(std::string_view name, const std::vector<std::string>& parts) {
        const std::string text = error_of(name);
        for (const std::string& part : parts) {
            EXPECT_NE(text.find(part), std::string::npos) << part << " in:\n" << text;
        }
    }
    std::string path_of(const fs::path& path) const { return (folder_ / path).string(); }

    fs::path base_, folder_;
};

TEST_F(ShaderCompilerTest, MakesTheWordsOfTheBuildForEveryShader) {
    for (const char* tree :
        {"shaders", "tests/framework/gpu/shaders", "tests/framework/runtime/shaders"}) {
        fs::copy(fs::path(OCKHAM_SOURCE) / tree, folder_,
            fs::copy_options::recursive | fs::copy_options::skip_existing);
    }
    const std::vector<std::string_view> names = shader_names();
    EXPECT_GT(names.size(), 100u);
    // CPU time, which the load of the machine does not change.
    const auto cpu_ms = [] { return 1e3 * double(std::clock()) / CLOCKS_PER_SEC; };
    double start_ms = cpu_ms();
    (void)compile_shader(folder_, names.front()); // glslang reads its built-in functions
    const double first_ms = cpu_ms() - start_ms;
    std::vector<std::pair<double, std::string_view>> times;
    for (const std::string_view name : names) {
        start_ms = cpu_ms();
        const std::vector<std::uint32_t> words = compile_shader(folder_, name);
        times.emplace_back(cpu_ms() - start_ms, name);
        EXPECT_TRUE(std::ranges::equal(words, find_shader(name))) << name;
    }
    std::ranges::sort(times);
    fmt::print("{} shaders: {:.1f} ms in the median, {:.1f} ms for {}; the first took {:.0f} ms\n",
        times.size(), times[times.size() / 2].first, times.back().first, times.back().second,
        first_ms);
}

TEST_F(ShaderCompilerTest, NamesFileAndLineOfEachMistake) {
    write_shader("test/a.comp", "void main() {\n    int a = nothing;\n    float b = 2 +;\n}");
    expect_error("test/a.comp", {"shader 'test/a.comp' does not compile:\n",
                                    "\n" + path_of("test/a.comp") + ":5: 'nothing'"});
    // glslang goes on to the end of the statement: two mistakes in one.
    write_shader("test/b.comp", "int f() { return nothing; }\nvoid main() {}");
    EXPECT_EQ(error_of("test/b.comp"),
        fmt::format("shader 'test/b.comp' does not compile:\n"
                    "{0}:4: 'nothing' : undeclared identifier\n"
                    "{0}:4: 'return' : type does not match, or is not convertible to, the "
                    "function's return type",
            path_of("test/b.comp")));
    write_shader("test/c.comp", "void f() {}");
    expect_error("test/c.comp", {"Missing entry point"});
    write("test/empty.comp", "");
    expect_error("test/empty.comp", {"does not compile:\n"});
    write("test/garbage.comp", std::string("\0\xff\x80#\"'\\\n{", 9));
    expect_error("test/garbage.comp", {"does not compile:\n"});
}

TEST_F(ShaderCompilerTest, NamesTheIncludedFileOfAMistake) {
    write_shader("test/a.comp", "#include \"test/deep.glsl\"\nvoid main() { f(); }");
    write("test/deep.glsl", "// one\n#include \"broken.glsl\"\n");
    write("test/broken.glsl", "// one\n// two\nvoid f() { int a = nothing; }\n");
    expect_error("test/a.comp", {"\n" + path_of("test/broken.glsl") + ":3: 'nothing'"});
    write("test/broken.glsl", "void f() {}\n");
    write_shader("test/a.comp", "#include \"test/deep.glsl\"\nvoid main() { g(); }");
    expect_error(
        "test/a.comp", {"\n" + path_of("test/a.comp") + ":5: 'g'"}); // lines go on after it
}

TEST_F(ShaderCompilerTest, SearchesIncludesBesideTheFileThenInTheFolder) {
    const auto with = [](int number) { return fmt::format("const int number = {};\n", number); };
    write_shader("test/a.comp", "#include \"number.glsl\"\n"
                                "layout(binding = 0) buffer Result { int result; };\n"
                                "void main() { result = number; }");
    expect_error("test/a.comp",
        {path_of("test/a.comp") + ":4: ", "'" + folder_.string() + "'", "number.glsl"});
    write("number.glsl", with(1));
    const auto in_folder = compile_shader(folder_, "test/a.comp");
    write("test/number.glsl", with(2));
    const auto beside = compile_shader(folder_, "test/a.comp");
    EXPECT_NE(in_folder, beside);
    fs::remove(folder_ / "number.glsl");
    EXPECT_EQ(compile_shader(folder_, "test/a.comp"), beside);
}

TEST_F(ShaderCompilerTest, VisitsEveryFileThatMatters) {
    write_shader("test/a.comp", "#include \"b.glsl\"\nvoid main() {}");
    write("b.glsl", "#include \"test/missing.glsl\"\n");
    std::set<fs::path> files;
    const auto visit = [&](const fs::path& file) { files.insert(file); };
    EXPECT_THROW(compile_shader(folder_, "test/a.comp", visit), Error);
    for (const char* path : {"test/a.comp", "b.glsl", "test/b.glsl", "test/missing.glsl"}) {
        EXPECT_TRUE(files.contains(folder_ / path)) << path;
    }
}

TEST_F(ShaderCompilerTest, ReadsNothingOutsideOfTheFolder) {
    write_text(base_ / "secret.glsl", "SECRET\n");
    const fs::path secret = base_ / "secret.glsl";
    fs::create_symlink(secret, folder_ / "link.glsl");
    fs::create_directory_symlink(base_, folder_ / "up");
    for (const std::string& include :
        {std::string("../secret.glsl"), std::string("../../secret.glsl"),
            std::string("test/../../secret.glsl"), secret.string(), std::string("link.glsl"),
            std::string("up/secret.glsl"), std::string("../not_there.glsl")}) {
        for (const std::string& quoted : {'"' + include + '"', '<' + include + '>'}) {
            write_shader("test/a.comp", "#include " + quoted + "\nvoid main() {}");
            const std::string text = error_of("test/a.comp");
            EXPECT_NE(text.find("is outside of '" + folder_.string() + "'"), std::string::npos)
                << quoted << "\n"
                << text;
            EXPECT_EQ(text.find("SECRET"), std::string::npos) << text;
        }
    }
    // Links and ".." that stay inside are fine, and so is a link as the folder itself.
    write("real.glsl", "");
    fs::create_symlink("real.glsl", folder_ / "inner.glsl");
    write_shader(
        "test/a.comp", "#include \"inner.glsl\"\n#include \"../real.glsl\"\nvoid main() {}");
    fs::create_directory_symlink(folder_, base_ / "alias");
    EXPECT_EQ(
        compile_shader(folder_, "test/a.comp"), compile_shader(base_ / "alias", "test/a.comp"));

    write_text(base_ / "outside.comp", "SECRET\n");
    fs::create_symlink(base_ / "outside.comp", folder_ / "link.comp");
    expect_error("../outside.comp", {"is outside of"});
    expect_error("link.comp", {"is outside of"});
    expect_error((base_ / "outside.comp").string(), {"is outside of"});
}

TEST_F(ShaderCompilerTest, RefusesWhatCannotBeCompiled) {
    expect_error("test/none.comp", {"shader 'test/none.comp' is not in '" + folder_.string()});
    expect_error("test/none.glsl", {"'test/none.glsl'", ".comp"});
    write_shader("test/self.comp", "#include \"self.glsl\"\nvoid main() {}");
    write("self.glsl", "#include \"self.glsl\"\n");
    expect_error("test/self.comp", {path_of("self.glsl") + ":1: ", "too deep"});
    fs::create_directory(folder_ / "folder.comp");
    expect_error("folder.comp", {"folder.comp"});
}

} // namespace
} // namespace ockham::gpu

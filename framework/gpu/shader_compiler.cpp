// SPDX-License-Identifier: Apache-2.0
#include "framework/gpu/shader_compiler.hpp"

#include "framework/core/error.hpp"
#include "framework/core/file.hpp"

#include <glslang/Public/ResourceLimits.h>
#include <glslang/Public/ShaderLang.h>
#include <glslang/SPIRV/GlslangToSpv.h>

#include <algorithm>
#include <cctype>
#include <sstream>

namespace ockham::gpu {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxFileBytes = std::size_t{1} << 24;
constexpr std::size_t kMaxIncludeDepth = 32; ///< deeper is a file that includes itself

EShLanguage stage_of(std::string_view name) {
    const fs::path extension = fs::path(shader_file(name)).extension();
    if (extension == ".comp") return EShLangCompute;
    if (extension == ".vert") return EShLangVertex;
    if (extension == ".frag") return EShLangFragment;
    fail_input("shader '{}' ends in none of .comp, .vert and .frag", name);
}

/// "#define MASKED 1" for each word of the variant.
std::string definitions_of(std::string_view name) {
    std::string text;
    std::string_view variant = name.substr(shader_file(name).size());
    while (!variant.empty()) {
        variant.remove_prefix(1); // the colon or comma
        const std::string_view word = variant.substr(0, variant.find(','));
        text += "#define ";
        for (const char c : word) {
            text += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
        }
        text += " 1\n";
        variant.remove_prefix(word.size());
    }
    return text;
}

/// Reads the files of one folder and no others.
class Sandbox {
public:
    Sandbox(const fs::path& folder, const FileVisitor& visit)
        : folder_(folder), root_(fs::canonical(folder)), visit_(visit) {}

    const fs::path& folder() const { return folder_; }

    /// Whether `file` is below the folder once links and ".." are followed.
    bool holds(const fs::path& file) const {
        std::error_code error;
        const fs::path real = fs::weakly_canonical(file, error);
        if (error) return false;
        return std::ranges::mismatch(root_, real).in1 == root_.end();
    }

    /// Whether `file`, which is below the folder, is there; it is visited either way.
    bool has(const fs::path& file) const {
        if (visit_) visit_(file);
        std::error_code error;
        return fs::is_regular_file(file, error);
    }

private:
    const fs::path folder_;
    const fs::path root_;
    const FileVisitor& visit_;
};

/// Answers #include for one compilation. glslang is built without exceptions: failures are results.
class Includer final : public glslang::TShader::Includer {
public:
    Includer(const Sandbox& sandbox, const fs::path& file)
        : sandbox_(sandbox), folders_{file.parent_path()} {}

    /// In quotes: beside the including file, then beside those that include it.
    IncludeResult* includeLocal(const char* header, const char*, std::size_t depth) override {
        folders_.resize(std::min(depth, folders_.size()));
        for (auto folder = folders_.rbegin(); folder != folders_.rend(); ++folder) {
            if (IncludeResult* const result = find(*folder, header, depth)) return result;
        }
        return nullptr;
    }

    /// In angle brackets, or in quotes and not found so far: below the folder.
    IncludeResult* includeSystem(const char* header, const char*, std::size_t depth) override {
        folders_.resize(std::min(depth, folders_.size()));
        if (IncludeResult* const result = find(sandbox_.folder(), header, depth)) return result;
        const fs::path file = sandbox_.folder() / header;
        if (fs::path(header).is_absolute() || !sandbox_.holds(file)) {
            return failure(fmt::format("is outside of '{}'", sandbox_.folder().string()));
        }
        return failure(fmt::format("is not in '{}'", sandbox_.folder().string()));
    }

    void releaseInclude(IncludeResult* result) override {
        if (!result) return;
        delete static_cast<std::string*>(result->userData);
        delete result;
    }

private:
    static IncludeResult* answer(const std::string& name, std::string text) {
        const auto* const kept = new std::string(std::move(text));
        return new IncludeResult(name, kept->data(), kept->size(), const_cast<std::string*>(kept));
    }
    static IncludeResult* failure(std::string text) { return answer("", std::move(text)); }

    /// Null where this folder does not have it.
    IncludeResult* find(const fs::path& folder, const char* header, std::size_t depth) {
        const fs::path file = (folder / header).lexically_normal();
        if (fs::path(header).is_absolute() || !sandbox_.holds(file) || !sandbox_.has(file)) {
            return nullptr;
        }
        if (depth > kMaxIncludeDepth) return failure("is included too deep, by itself perhaps");
        try {
            std::string text = read_text(file, kMaxFileBytes);
            folders_.push_back(file.parent_path());
            return answer(file.string(), std::move(text));
        } catch (const std::exception& error) {
            return failure(error.what());
        }
    }

    const Sandbox& sandbox_;
    std::vector<fs::path> folders_; ///< of the shader and of the files that are open by #include
};

/// With "file:line: message" for each "ERROR: file:line: message" of glslang's log.
[[noreturn]] void fail_with(std::string_view name, const std::string& log) {
    std::string errors;
    std::istringstream lines(log);
    for (std::string line; std::getline(lines, line);) {
        constexpr std::string_view kError = "ERROR: ";
        // What only says that this was all, or counts it, is no mistake.
        if (!line.starts_with(kError) || line.find("No code generated") != std::string::npos ||
            line.find("compilation terminated") != std::string::npos) {
            continue;
        }
        while (line.ends_with(' ')) line.pop_back();
        errors += '\n';
        errors += line.substr(kError.size());
    }
    fail_input("shader '{}' does not compile:{}", name, errors);
}

} // namespace

std::string_view shader_file(std::string_view name) { return name.substr(0, name.find(':')); }

std::vector<std::uint32_t> compile_shader(
    const fs::path& folder, std::string_view name, const FileVisitor& visit) {
    static const struct Process {
        Process() { glslang::InitializeProcess(); }
        ~Process() { glslang::FinalizeProcess(); }
    } process;

    const EShLanguage stage = stage_of(name);
    const Sandbox sandbox(folder, visit);
    const fs::path file = folder / shader_file(name);
    if (!sandbox.holds(file)) {
        fail_input("shader '{}' is outside of '{}'", name, folder.string());
    }
    if (!sandbox.has(file)) fail_input("shader '{}' is not in '{}'", name, folder.string());
    const std::string text = read_text(file, kMaxFileBytes);
    const std::string file_name = file.string();
    const std::string definitions = definitions_of(name);

    glslang::TShader shader(stage);
    const char* const texts[] = {text.data()};
    const int lengths[] = {static_cast<int>(text.size())};
    const char* const names[] = {file_name.c_str()};
    shader.setStringsWithLengthsAndNames(texts, lengths, names, 1);
    shader.setPreamble(definitions.c_str());
    shader.setEnvInput(glslang::EShSourceGlsl, stage, glslang::EShClientVulkan, 100);
    shader.setEnvClient(glslang::EShClientVulkan, glslang::EShTargetVulkan_1_3);
    shader.setEnvTarget(glslang::EShTargetSpv, glslang::EShTargetSpv_1_6);
    constexpr auto kRules = static_cast<EShMessages>(EShMsgSpvRules | EShMsgVulkanRules);
    constexpr int kVersion = 100; // where the text has no #version, as the command line tool
    Includer includer(sandbox, file);
    if (!shader.parse(GetDefaultResources(), kVersion, false, kRules, includer)) {
        fail_with(name, shader.getInfoLog());
    }
    glslang::TProgram program;
    program.addShader(&shader);
    if (!program.link(kRules)) fail_with(name, program.getInfoLog());
    std::vector<std::uint32_t> words;
    glslang::GlslangToSpv(*program.getIntermediate(stage), words);
    return words;
}

} // namespace ockham::gpu

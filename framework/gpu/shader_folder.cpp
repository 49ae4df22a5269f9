// SPDX-License-Identifier: Apache-2.0
#include "framework/gpu/shader_folder.hpp"

#include "framework/core/error.hpp"
#include "framework/gpu/shader_compiler.hpp"

#include <algorithm>
#include <system_error>

namespace ockham::gpu {

namespace fs = std::filesystem;

ShaderFolder::ShaderFolder(fs::path folder) : folder_(std::move(folder)) {
    std::error_code error;
    const fs::file_status status = fs::status(folder_, error);
    if (fs::is_directory(status)) return;
    fail_input("cannot take shaders from '{}': {}; name a folder like the project's shaders/",
        folder_.string(), fs::exists(status) ? "it is no folder" : "there is no such folder");
}

ShaderFolder::Stamp ShaderFolder::stamp_of(const fs::path& file) {
    std::error_code error;
    const fs::file_time_type written = fs::last_write_time(file, error);
    if (error) return {fs::file_time_type::min(), 0};
    const std::uintmax_t bytes = fs::file_size(file, error);
    return {written, error ? 0 : bytes};
}

std::vector<std::uint32_t> ShaderFolder::load(const std::string& name) {
    std::map<fs::path, Stamp>& files = loaded_[name];
    files.clear();
    // Before the file is read: what is written meanwhile then counts as a change.
    const auto visit = [&](const fs::path& file) { files.emplace(file, stamp_of(file)); };
    const fs::path file = folder_ / shader_file(name);
    visit(file);
    std::error_code error;
    if (!fs::exists(fs::symlink_status(file, error))) return {};
    return compile_shader(folder_, name, visit);
}

std::vector<std::string> ShaderFolder::changed() {
    std::map<fs::path, Stamp> now; // variants share files
    std::vector<std::string> names;
    for (const auto& [name, files] : loaded_) {
        const bool differs = std::ranges::any_of(files, [&](const auto& row) {
            const auto [found, added] = now.try_emplace(row.first);
            if (added) found->second = stamp_of(row.first);
            return found->second != row.second;
        });
        if (differs) names.push_back(name);
    }
    return names;
}

} // namespace ockham::gpu

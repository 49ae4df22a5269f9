// SPDX-License-Identifier: Apache-2.0
// Hot reload: a folder of GLSL whose files stand in for the embedded shaders of the same name. Give
// it to Pipelines::reload_from(); Pipelines::reload() then takes up what has changed. The library
// ockham_shader_reload, so that only who reloads links a compiler.
#pragma once

#include "framework/gpu/shader.hpp"

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace ockham::gpu {

class ShaderFolder final : public ShaderSource {
public:
    /// Throws Error(input) unless `folder` is one.
    explicit ShaderFolder(std::filesystem::path folder);

    /// Compiles `name` with compile_shader() and its errors; empty where the folder has no such
    /// file.
    std::vector<std::uint32_t> load(const std::string& name) override;
    /// Costs one look at the time and size of each file that the loaded shaders consist of.
    std::vector<std::string> changed() override;

private:
    struct Stamp {
        std::filesystem::file_time_type written;
        std::uintmax_t bytes = 0;

        bool operator==(const Stamp&) const = default;
    };
    /// Of a file that is not there: one that no file has.
    static Stamp stamp_of(const std::filesystem::path& file);

    std::filesystem::path folder_;
    /// By shader: its files as they were when it was loaded.
    std::map<std::string, std::map<std::filesystem::path, Stamp>> loaded_;
};

} // namespace ockham::gpu

// SPDX-License-Identifier: Apache-2.0
// GLSL to SPIR-V in the running program, with the settings of the build
// (cmake/CompileShaders.cmake) and so with its words. Only ShaderFolder calls it: shaders are
// otherwise compiled when the project is built. The one place that knows glslang; who does not link
// ockham_shader_reload is without it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string_view>
#include <vector>

namespace ockham::gpu {

/// Called with each file before it is read, also with files that were looked for and are not there,
/// since an include would be found elsewhere once they are. Must not throw.
using FileVisitor = std::function<void(const std::filesystem::path& file)>;

/// SPIR-V for Vulkan 1.3 of `name` below `folder`: "surface/metrics.comp", or with a variant
/// "surface/gbuffer.frag:masked,textured", which defines MASKED and TEXTURED as 1. Includes in
/// quotes are searched beside the including file, beside those that include it, then in `folder`.
///
/// Nothing outside of `folder` is read, whatever "..", absolute paths or symbolic links say. Throws
/// Error(input) with a line "file:line: message" for each mistake, of included files too; also for
/// files that cannot be read and names that end neither in .comp nor .vert nor .frag.
std::vector<std::uint32_t> compile_shader(
    const std::filesystem::path& folder, std::string_view name, const FileVisitor& visit = {});

/// The part of a shader's name that is a path: all before the colon of its variant.
std::string_view shader_file(std::string_view name);

} // namespace ockham::gpu

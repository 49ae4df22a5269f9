// SPDX-License-Identifier: Apache-2.0
// SPIR-V embedded at build time, found by name, and what it says about itself. Shaders are the one
// source of truth for bindings, push constants and workgroup size: C++ repeats none of them.
#pragma once

#include <vulkan/vulkan_core.h>

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace ockham::gpu {

/// Values of specialisation constants: (constant_id, 32-bit value).
using Specialization = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

/// One row of the tables that ockham_add_shaders() generates.
struct EmbeddedShader {
    template <std::size_t N>
    EmbeddedShader(const char* shader_name, const std::uint32_t (&shader_words)[N])
        : name(shader_name), words(shader_words) {}

    std::string_view name;
    std::span<const std::uint32_t> words;
};

/// Adds a table that lives as long as the program. A name that exists already must be the same
/// shader: two libraries may embed one file.
struct ShaderRegistration {
    explicit ShaderRegistration(std::span<const EmbeddedShader> table);
};

/// SPIR-V of "surface/metrics.comp" or, for variants, "surface/gbuffer.frag:masked". Throws
/// Error(input) with the names that exist of its file, or else those of all files.
std::span<const std::uint32_t> find_shader(std::string_view name);
/// All names that find_shader() knows, sorted.
std::vector<std::string_view> shader_names();

/// Shaders that stand in for embedded ones while the program runs; Pipelines asks, one thread at a
/// time. shader_folder.hpp has the one there is.
class ShaderSource {
public:
    virtual ~ShaderSource() = default;
    /// SPIR-V in place of the embedded shader `name`; empty: the embedded one. Throws Error(input)
    /// where there is something that cannot be compiled.
    virtual std::vector<std::uint32_t> load(const std::string& name) = 0;
    /// Names given to load() for which it may have another answer now than it had last.
    virtual std::vector<std::string> changed() = 0;
};

/// One resource of a shader that its code uses.
struct ShaderBinding {
    /// Name of the variable (of the block's instance for buffers), else of the block.
    std::string name;
    std::uint32_t set = 0;
    std::uint32_t binding = 0;
    VkDescriptorType type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    bool reads = true;  ///< not `writeonly`
    bool writes = true; ///< not `readonly`
    /// Images: what view the shader expects, and for storage images the format it declares.
    VkImageViewType view_type = VK_IMAGE_VIEW_TYPE_2D;
    VkFormat format = VK_FORMAT_UNDEFINED;
};

struct Reflection {
    std::string name;
    VkShaderStageFlagBits stage = VK_SHADER_STAGE_COMPUTE_BIT;
    std::vector<ShaderBinding> bindings;
    std::uint32_t push_bytes = 0; ///< 0: none
    std::vector<std::uint32_t> constant_ids;

    /// Invocations per workgroup and axis after specialisation; compute only.
    std::array<std::uint32_t, 3> local_size(const Specialization& specialization) const;

    std::array<std::uint32_t, 3> default_local_size{1, 1, 1};
    std::array<std::optional<std::uint32_t>, 3> local_size_ids; ///< local_size_x_id and so on
};

/// Throws Error(input) naming the shader where it holds what the runtime does not bind: descriptor
/// arrays, separate samplers, multisampled images, texel buffers, or more than the portable budget
/// (4 sets, 16 storage images, 128 bytes of push constants, 32 KiB of shared variables).
Reflection reflect(std::string_view name, std::span<const std::uint32_t> words);

} // namespace ockham::gpu

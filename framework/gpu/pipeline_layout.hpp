// SPDX-License-Identifier: Apache-2.0
// What the shaders of one pipeline want bound, from their reflections. Pipelines makes layouts and
// keeps them; the runtime reads them when it binds.
#pragma once

#include "framework/gpu/shader.hpp"

#include <vulkan/vulkan_core.h>

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace ockham::gpu {

class Device;

/// What the shaders of one pipeline need bound, all stages together.
struct PipelineLayout {
    struct Slot {
        ShaderBinding binding; ///< reads and writes: by any stage
        std::string shader;    ///< one that uses it, for messages
        VkShaderStageFlags stages = 0;
    };
    VkPipelineLayout handle = VK_NULL_HANDLE;
    std::vector<VkDescriptorSetLayout> sets;
    std::vector<Slot> slots; ///< by set, then binding
    /// Set 0 is given by push descriptors; the others, and without this set 0 too, by sets.
    bool pushes_set_0 = false;
    std::uint32_t push_bytes = 0;
    VkShaderStageFlags push_stages = 0;
};

/// Of all stages together, without handles. Throws Error(input) where stages disagree.
PipelineLayout layout_of(std::span<const Reflection* const> shaders);

/// Throws Error(input) unless passes that were declared for `embedded` can run `reloaded`: it may
/// leave bindings out and number them anew, and that is all. `shaders` is for the text.
void expect_fits(
    const PipelineLayout& reloaded, const PipelineLayout& embedded, std::string_view shaders);

/// Creates the handles; they are the caller's, also those made before an Error(device).
void create_handles(const Device& device, PipelineLayout& layout, std::string_view shaders);

} // namespace ockham::gpu

// SPDX-License-Identifier: Apache-2.0
// How a pass touches a resource, and what that means to Vulkan: stages, access bits, layout.
// One table, read by the compiler, the runtime and the dumps. Enums only, no Vulkan functions.
#pragma once

#include <vulkan/vulkan_core.h>

#include <cstdint>

namespace ockham {

enum class Access : std::uint8_t {
    sampled,            ///< image through a sampler or texelFetch
    storage_read,       ///< storage buffer or image, read only
    storage_write,      ///< storage buffer or image; earlier content is lost to the graph
    storage_read_write, ///< storage buffer or image, keeps earlier content
    uniform,            ///< uniform buffer
    indirect,           ///< arguments of an indirect dispatch or draw
    vertex,             ///< vertex buffer
    index,              ///< index buffer
    color_attachment,   ///< written by a raster pass
    depth_attachment,   ///< tested and written by a raster pass
    transfer_read,      ///< source of a copy
    transfer_write,     ///< destination of a copy, fill or clear; the rest keeps its content
    host_read,          ///< read by the host after the execution
};

/// Which programmable stage uses it; `fixed` where the access itself says (attachments, copies).
enum class Stage : std::uint8_t { compute, vertex, fragment, fixed };

/// The Vulkan meaning of one access; the state that it leaves a resource in.
struct AccessState {
    VkPipelineStageFlags2 stages = VK_PIPELINE_STAGE_2_NONE;
    VkAccessFlags2 access = VK_ACCESS_2_NONE;
    VkImageLayout layout = VK_IMAGE_LAYOUT_UNDEFINED; ///< images only
    /// External resources only: who owns it. IGNORED: whichever queue family uses it.
    std::uint32_t queue_family = VK_QUEUE_FAMILY_IGNORED;

    bool operator==(const AccessState&) const = default;
};

AccessState state_of(Access access, Stage stage);
bool reads(Access access);     ///< sees earlier content (depth_attachment and read_write included)
bool writes(Access access);    ///< changes content
bool in_shader(Access access); ///< made by a shader, so it has a stage and a binding name
/// Usage bits that the resource must be created with for this access.
VkBufferUsageFlags buffer_usage(Access access);
VkImageUsageFlags image_usage(Access access);
const char* name_of(Access access);
const char* name_of(Stage stage);

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
// Vulkan's flags and sizes as people read them: "compute+fragment", "45.3 MiB". For the dumps and
// explanations of framework/graph only.
#pragma once

#include <vulkan/vulkan_core.h>

#include <cstdint>
#include <string>

namespace ockham {

std::string stages_text(VkPipelineStageFlags2 stages); ///< "compute+fragment", "none"
std::string access_text(VkAccessFlags2 access);        ///< "storage_read+storage_write"
std::string layout_text(VkImageLayout layout);         ///< "general"
std::string size_text(std::uint64_t bytes);            ///< "12 B", "1.5 KiB" or "45.3 MiB"

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
// The image formats that graphs may use: bytes per texel and name. One table; what a device can do
// with a format is not its business.
#pragma once

#include <vulkan/vulkan_core.h>

#include <cstdint>
#include <string>

namespace ockham {

/// Bytes per texel of the formats that the project uses; 0 for others, UNDEFINED included.
std::uint32_t texel_bytes(VkFormat format);
/// "R32_SFLOAT", or "VkFormat 1000" for one that the project does not use.
std::string format_text(VkFormat format);

} // namespace ockham

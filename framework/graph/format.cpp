// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/format.hpp"

#include <array>

namespace ockham {

namespace {

struct Row {
    const char* name = nullptr;
    std::uint32_t texel_bytes = 0;
};

/// Indexed by format; the core formats are numbered without gaps.
constexpr auto kRows = [] {
    std::array<Row, VK_FORMAT_ASTC_12x12_SRGB_BLOCK + 1> rows{};
    rows[VK_FORMAT_R8_UNORM] = {"R8_UNORM", 1};
    rows[VK_FORMAT_R8_UINT] = {"R8_UINT", 1};
    rows[VK_FORMAT_R8G8_UNORM] = {"R8G8_UNORM", 2};
    rows[VK_FORMAT_R8G8B8A8_UNORM] = {"R8G8B8A8_UNORM", 4};
    rows[VK_FORMAT_R8G8B8A8_UINT] = {"R8G8B8A8_UINT", 4};
    rows[VK_FORMAT_R8G8B8A8_SRGB] = {"R8G8B8A8_SRGB", 4};
    rows[VK_FORMAT_B8G8R8A8_UNORM] = {"B8G8R8A8_UNORM", 4};
    rows[VK_FORMAT_B8G8R8A8_SRGB] = {"B8G8R8A8_SRGB", 4};
    rows[VK_FORMAT_R16_UNORM] = {"R16_UNORM", 2};
    rows[VK_FORMAT_R16_UINT] = {"R16_UINT", 2};
    rows[VK_FORMAT_R16_SFLOAT] = {"R16_SFLOAT", 2};
    rows[VK_FORMAT_R16G16_UNORM] = {"R16G16_UNORM", 4};
    rows[VK_FORMAT_R16G16_SNORM] = {"R16G16_SNORM", 4};
    rows[VK_FORMAT_R16G16_SFLOAT] = {"R16G16_SFLOAT", 4};
    rows[VK_FORMAT_R16G16B16A16_UNORM] = {"R16G16B16A16_UNORM", 8};
    rows[VK_FORMAT_R16G16B16A16_SFLOAT] = {"R16G16B16A16_SFLOAT", 8};
    rows[VK_FORMAT_R32_UINT] = {"R32_UINT", 4};
    rows[VK_FORMAT_R32_SFLOAT] = {"R32_SFLOAT", 4};
    rows[VK_FORMAT_R32G32_UINT] = {"R32G32_UINT", 8};
    rows[VK_FORMAT_R32G32_SFLOAT] = {"R32G32_SFLOAT", 8};
    rows[VK_FORMAT_R32G32B32A32_UINT] = {"R32G32B32A32_UINT", 16};
    rows[VK_FORMAT_R32G32B32A32_SFLOAT] = {"R32G32B32A32_SFLOAT", 16};
    rows[VK_FORMAT_A2B10G10R10_UNORM_PACK32] = {"A2B10G10R10_UNORM", 4};
    rows[VK_FORMAT_B10G11R11_UFLOAT_PACK32] = {"B10G11R11_UFLOAT", 4};
    rows[VK_FORMAT_E5B9G9R9_UFLOAT_PACK32] = {"E5B9G9R9_UFLOAT", 4};
    rows[VK_FORMAT_D32_SFLOAT] = {"D32_SFLOAT", 4};
    rows[VK_FORMAT_S8_UINT] = {"S8_UINT", 1};
    return rows;
}();

Row row(VkFormat format) {
    const auto index = static_cast<std::size_t>(format);
    return index < kRows.size() ? kRows[index] : Row{};
}

} // namespace

std::uint32_t texel_bytes(VkFormat format) { return row(format).texel_bytes; }

std::string format_text(VkFormat format) {
    const char* const name = row(format).name;
    return name ? name : "VkFormat " + std::to_string(static_cast<int>(format));
}

} // namespace ockham

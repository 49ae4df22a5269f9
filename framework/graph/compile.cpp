// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/compile.hpp"

#include "framework/core/timer.hpp"
#include "framework/graph/phases.hpp"

#include <algorithm>

namespace ockham {

Plan compile(
    const Declaration& declaration, const Capabilities& capabilities, const Policy& policy) {
    const Timer timer;
    Plan plan;
    validate(declaration, capabilities);
    cull(declaration, plan);
    place(declaration, capabilities, policy, plan);
    synchronize(declaration, plan);
    plan.compile_us = 1e6 * timer.seconds();
    return plan;
}

MemoryNeed estimate_memory(const ResourceDecl& resource) {
    constexpr std::uint64_t alignment = 256;
    std::uint64_t bytes = resource.buffer.bytes;
    if (resource.kind == ResourceKind::image) {
        const ImageDesc& image = resource.image;
        bytes = 0;
        for (std::uint32_t mip = 0; mip < std::min(image.mips, 32u); ++mip)
            bytes += std::uint64_t{std::max(image.width >> mip, 1u)} *
                     std::max(image.height >> mip, 1u) * std::max(image.depth >> mip, 1u);
        bytes *= std::uint64_t{image.layers} * texel_bytes(image.format);
    }
    return {(bytes + alignment - 1) / alignment * alignment, alignment, ~std::uint32_t{0}};
}

std::uint32_t texel_bytes(VkFormat format) {
    switch (format) {
    case VK_FORMAT_R8_UNORM:
    case VK_FORMAT_R8_UINT:
        return 1;
    case VK_FORMAT_R8G8_UNORM:
    case VK_FORMAT_R16_UNORM:
    case VK_FORMAT_R16_UINT:
    case VK_FORMAT_R16_SFLOAT:
        return 2;
    case VK_FORMAT_R8G8B8A8_UNORM:
    case VK_FORMAT_R8G8B8A8_UINT:
    case VK_FORMAT_R8G8B8A8_SRGB:
    case VK_FORMAT_B8G8R8A8_UNORM:
    case VK_FORMAT_B8G8R8A8_SRGB:
    case VK_FORMAT_R16G16_UNORM:
    case VK_FORMAT_R16G16_SNORM:
    case VK_FORMAT_R16G16_SFLOAT:
    case VK_FORMAT_R32_SFLOAT:
    case VK_FORMAT_R32_UINT:
    case VK_FORMAT_B10G11R11_UFLOAT_PACK32:
    case VK_FORMAT_A2B10G10R10_UNORM_PACK32:
    case VK_FORMAT_E5B9G9R9_UFLOAT_PACK32:
    case VK_FORMAT_D32_SFLOAT:
        return 4;
    case VK_FORMAT_R16G16B16A16_UNORM:
    case VK_FORMAT_R16G16B16A16_SFLOAT:
    case VK_FORMAT_R32G32_SFLOAT:
    case VK_FORMAT_R32G32_UINT:
        return 8;
    case VK_FORMAT_R32G32B32A32_SFLOAT:
    case VK_FORMAT_R32G32B32A32_UINT:
        return 16;
    default:
        return 0;
    }
}

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/compile.hpp"

#include "framework/core/timer.hpp"
#include "framework/graph/compile/phases.hpp"

#include <algorithm>

namespace ockham {

Plan compile(
    const Declaration& declaration, const Capabilities& capabilities, const Policy& policy) {
    const Timer timer;
    Plan plan;
    const Pieces pieces = validate(declaration, capabilities);
    cull(declaration, pieces, plan);
    order(declaration, pieces, policy, plan);
    schedule(declaration, pieces, capabilities, policy, plan);
    place(declaration, capabilities, policy, plan);
    synchronize(declaration, pieces, capabilities, policy, plan);
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

} // namespace ockham

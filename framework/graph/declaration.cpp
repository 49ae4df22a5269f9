// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/declaration.hpp"

namespace ockham {

std::uint32_t Names::add(std::string_view text) {
    const auto known = index_.find(text);
    if (known != index_.end()) return known->second;
    const auto index = static_cast<std::uint32_t>(texts_.size());
    texts_.emplace_back(text);
    index_.emplace(text, index);
    return index;
}

Part part_of(const Declaration& declaration, const Use& use) {
    const ResourceDecl& resource = declaration.resources[use.resource];
    Part part = use.part == kNone ? Part{} : declaration.parts[use.part];
    if (part.bytes == kRest) part.bytes = resource.buffer.bytes - part.offset;
    if (part.mips == kRestOfMips) part.mips = resource.image.mips - part.first_mip;
    if (part.layers == kRestOfLayers) part.layers = resource.image.layers - part.first_layer;
    return part;
}

} // namespace ockham

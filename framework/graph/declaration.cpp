// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/declaration.hpp"

#include <algorithm>

namespace ockham {

Part part_of(const Declaration& declaration, const Use& use) {
    const ResourceDecl& resource = declaration.resources[use.resource];
    Part part = use.part == kNone ? Part{} : declaration.parts[use.part];
    part.bytes = std::min(part.bytes, resource.buffer.bytes - part.offset);
    part.mips = std::min(part.mips, resource.image.mips - part.first_mip);
    part.layers = std::min(part.layers, resource.image.layers - part.first_layer);
    return part;
}

} // namespace ockham

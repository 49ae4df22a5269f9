// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/declaration.hpp"

namespace ockham {

Part part_of(const Declaration& declaration, const Use& use) {
    const ResourceDecl& resource = declaration.resources[use.resource];
    Part part = use.part == kNone ? Part{} : declaration.parts[use.part];
    if (part.bytes == kRest) part.bytes = resource.buffer.bytes - part.offset;
    if (part.mips == kRestOfMips) part.mips = resource.image.mips - part.first_mip;
    if (part.layers == kRestOfLayers) part.layers = resource.image.layers - part.first_layer;
    return part;
}

} // namespace ockham

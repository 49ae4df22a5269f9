// SPDX-License-Identifier: Apache-2.0
// What a display shows of a picture: the values that filters of finished pictures look at. No
// exposure and no tone curve: those come with the file.
#pragma once

#include "framework/graph/graph.hpp"

namespace ockham {

/// `radiance`: linear. Returns "display", rgba16f: sRGB-encoded and clamped to [0,1], alpha is the
/// Rec. 709 luma of the encoded colour.
ImageHandle add_display(Graph& graph, ImageHandle radiance);

} // namespace ockham

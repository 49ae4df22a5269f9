// SPDX-License-Identifier: Apache-2.0
// S: the first sample of every pixel, shaded for the whole pixel, or for all of its surface in it.
// The picture itself at m = 1; what the shading metric looks at otherwise (Hollaender et al. 2013,
// section 3).
#pragma once

#include "passes/surface/shading_inputs.hpp"

namespace ockham {

/// Returns "first_sample": rgba32f, linear radiance and whether a surface was hit.
/// `clusters`: labels of the windows' samples (clusters.hpp). With them, a footprint has the size
/// of the sample's surface in its window, not of the pixel, and shows the means of that surface.
ImageHandle add_first_sample(
    Graph& graph, const ShadingInputs& in, const ShadingParams& params, ImageHandle clusters = {});

} // namespace ockham

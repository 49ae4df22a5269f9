// SPDX-License-Identifier: Apache-2.0
// S: the first sample of every pixel, shaded with the footprint of the whole pixel. The picture
// itself at m = 1; what the shading metric looks at otherwise (Hollaender et al. 2013, section 3).
#pragma once

#include "passes/surface/shading_inputs.hpp"

namespace ockham {

/// Returns "first_sample": rgba32f, linear radiance and whether a surface was hit.
ImageHandle add_first_sample(Graph& graph, const ShadingInputs& in, const ShadingParams& params);

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
// Bloom: light that a lens scatters around what is bright, as a Gaussian over the whole picture
// (Spencer, Shirley, Zimmerman, Greenberg, "Physically-Based Glare Effects for Digital Images",
// SIGGRAPH 1995, who add several lobes). No threshold: every pixel gives the same share away.
#pragma once

#include "framework/graph/graph.hpp"

namespace ockham {

struct BloomParams {
    float share = 0.1f; ///< of each pixel's light that is scattered, 0 ... 1
    float sigma = 8;    ///< standard deviation of where it goes, pixels, > 0
};

/// `radiance`: rgba32f, linear. Returns "bloom", rgba32f: (1 - share) radiance + share (Gaussian *
/// radiance), cut off at 4 sigma and normalised. The picture goes on beyond its sides as it is
/// there, so that even light stays as it is. Alpha passes bit for bit. Costs two passes of
/// 2 ceil(4 sigma) + 1 texels per pixel.
ImageHandle add_bloom(Graph& graph, ImageHandle radiance, const BloomParams& params);

} // namespace ockham

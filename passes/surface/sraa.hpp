// SPDX-License-Identifier: Apache-2.0
// Subpixel reconstruction (Chajdas, McGuire, Luebke 2011): one shaded sample per pixel, spread over
// the samples of m x m geometry by a filter that keeps to surfaces. A baseline.
#pragma once

#include "passes/surface/gbuffer.hpp"

namespace ockham {

struct SraaInputs {
    BufferHandle frame;
    Gbuffer gbuffer;
    ImageHandle first_sample;
};

struct SraaParams {
    float radius = 0.4f;      ///< standard deviation of the weight over the picture, pixels, > 0
    float plane_error = 1.0f; ///< of the distance from the sample's plane, pixels at its depth, > 0
    float normal_power = 8.0f; ///< of the cosine between the normals, >= 0
};

/// Returns "sraa": rgba32f, linear radiance and the share of samples that hit.
ImageHandle add_sraa(Graph& graph, const SraaInputs& in, const SraaParams& params = {});

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
// FLIP: the difference that a viewer sees when flipping between two pictures on a 0.7 m wide
// display of 3840 pixels at 0.7 m (67 pixels per degree). LDR: Andersson et al. 2020; HDR:
// Andersson et al. 2021, with ACES tone mapping. Called through image_error.hpp.
#pragma once

#include "framework/core/image.hpp"

namespace ockham {

/// A per-pixel difference in [0,1] and what it amounts to.
struct Flip {
    double mean = 0;
    double max = 0;
    /// One channel, "flip".
    Image map;
};

/// Of linear, finite R, G, B of one size; values are clamped to [0,1] first.
Flip flip(const Image& test, const Image& reference);

/// What HDR-FLIP found, and the exposures (powers of two) that it looked at.
struct HdrFlip : Flip {
    double start_exposure = 0; ///< the reference's brightest pixel just does not saturate
    double stop_exposure = 0;  ///< nor does its median pixel
    int exposures = 0;
};

/// Per pixel the largest FLIP over exposures from start to stop, one per stop and at least two.
/// Linear, finite R, G, B of one size; negative values count as 0. Takes as long as `exposures`
/// calls of flip(): long where the median of the reference is black.
HdrFlip hdr_flip(const Image& test, const Image& reference);

} // namespace ockham

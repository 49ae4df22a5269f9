// SPDX-License-Identifier: Apache-2.0
// All differences between a picture and its reference, in one call: what --reference, the compare
// tool and the charts print. Each metric has its own header beside this one.
#pragma once

#include "framework/core/image.hpp"
#include "framework/image_error/flip.hpp"

#include <cstddef>
#include <limits>
#include <optional>

namespace ockham {

/// "Displayed" values are sRGB-encoded and clamped to [0,1]; R, G, B only, all pixels.
struct ImageError {
    /// Displayed: mean of the squared difference over pixels and R, G, B.
    double mse = 0;
    /// Displayed: decibels, peak 1. Infinite for equal pictures; JSON gets 999 then.
    double psnr = std::numeric_limits<double>::infinity();
    /// Displayed: Wang et al. 2004 on luma; 1 = equal.
    double ssim = 1;
    /// Displayed: mean of the SSIM of R, of G and of B.
    double ssim_rgb = 1;
    /// Displayed: largest absolute difference of a value.
    double max = 0;
    /// Displayed: 99 % of the pixels differ by at most this in each of R, G, B.
    double p99 = 0;
    /// Linear: mean of (test - reference)^2 / (reference^2 + 0.01) over pixels and R, G, B.
    double relmse = 0;
    /// LDR-FLIP of linear values clamped to [0,1].
    Flip flip;
    /// A value of either picture exceeds 1, which "displayed" clamps away.
    bool hdr = false;
    /// Linear: where `hdr`.
    std::optional<HdrFlip> hdr_flip;
    /// Displayed: per pixel the largest absolute difference of R, G, B; one channel, "error".
    Image map;
    /// Pixels of the test picture with a NaN or an infinity in R, G or B. Each counts as an error
    /// of 1 in mse, max, p99, relmse and both FLIPs, and as white on black in SSIM.
    std::size_t non_finite = 0;
};

/// Compares linear R, G, B. Throws Error(input) if the sizes differ (naming both), if a picture
/// lacks R, G or B, or if the reference has non-finite pixels.
ImageError image_error(const Image& test, const Image& reference);

/// R, G, B as a display shows them: sRGB-encoded, clamped to [0,1].
Image displayed(const Image& linear);

} // namespace ockham

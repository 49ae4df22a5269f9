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
    double mse = 0; ///< displayed; mean over pixels and R, G, B
    double psnr = std::numeric_limits<double>::infinity(); ///< displayed; decibels, peak 1;
                                                           ///< infinite for equal pictures
    double ssim = 1;     ///< displayed; Wang et al. 2004 on luma, 1 = equal
    double ssim_rgb = 1; ///< displayed; mean of the SSIM of R, G and B
    double max = 0;      ///< displayed; largest absolute difference
    double p99 = 0;      ///< displayed; 99 % of the pixels differ by at most this in R, G and B
    double relmse = 0;   ///< linear; mean of (t - r)^2 / (r^2 + 0.01) over pixels and R, G, B
    Flip flip;           ///< LDR-FLIP of linear values clamped to [0,1]

    bool hdr = false; ///< a value of either picture exceeds 1, which "displayed" clamps away
    std::optional<HdrFlip> hdr_flip; ///< where `hdr`

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

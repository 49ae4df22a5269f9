// SPDX-License-Identifier: Apache-2.0
// Structural similarity after Wang, Bovik, Sheikh and Simoncelli 2004: Gaussian window of sigma
// 1.5 cut at 11 x 11, population variances, K1 = 0.01, K2 = 0.03. Images are display-encoded,
// [0,1], finite, and of one size. Called through image_error.hpp.
#pragma once

#include "framework/core/image.hpp"

namespace ockham {

/// Mean SSIM of luma 0.2989 R + 0.5870 G + 0.1140 B: 1 for equal images, at least -1. The mean is
/// over the pixels whose window lies inside the image; along an axis of fewer than 11 pixels over
/// all of them, with the image mirrored at its edges.
double ssim_luma(const Image& test, const Image& reference);

/// The mean of the mean SSIM of R, of G and of B.
double ssim_rgb(const Image& test, const Image& reference);

} // namespace ockham

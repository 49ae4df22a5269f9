// SPDX-License-Identifier: Apache-2.0
// Differences pixel by pixel. Each function compares R, G, B of two finite images of one size, in
// whatever encoding they are; image_error.hpp is the front door that encodes, checks and counts.
#pragma once

#include "framework/core/image.hpp"

#include <vector>

namespace ockham {

/// Mean of the squared difference over pixels and R, G, B.
double mse(const Image& test, const Image& reference);

/// 10 log10(1 / mse) in decibels: the peak is 1, so that the values are to be in [0,1].
/// Infinite for mse = 0; writers of JSON put 999 there.
double psnr(double mse);

/// Mean over pixels and R, G, B of (test - reference)^2 / (reference^2 + 0.01), for linear values
/// (Rousselle et al. 2011, the denoising literature's relative MSE).
double relative_mse(const Image& test, const Image& reference);

/// Per pixel the largest |test - reference| of R, G, B.
std::vector<float> absolute_error(const Image& test, const Image& reference);

/// The smallest of `values` that at least `fraction` of them do not exceed (nearest rank); 0 for
/// none. `fraction` in (0,1].
double quantile(std::vector<float> values, double fraction);

} // namespace ockham

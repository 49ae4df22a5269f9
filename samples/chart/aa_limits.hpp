// SPDX-License-Identifier: Apache-2.0
// How few samples could do: the counts that somebody would choose who knows the full reference. Not
// a renderer: it is given the pictures with 1 ... n samples everywhere, as the real graph makes
// them, and puts pixels of them together. Called by charts.
#pragma once

#include "framework/core/image.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace ockham {

/// One point of a curve over lambda. Errors are displayed: sRGB-encoded, clamped, over R, G, B.
struct LimitPoint {
    double lambda = 0;          ///< what a sample may cost in squared error of a pixel
    double samples_percent = 0; ///< of all n
    double mse = 0;
    double psnr = 0; ///< decibels, peak 1
};

/// The k in 1 ... n with the least variance / k * (n - k) / (n - 1) + lambda k: the expected error
/// of a mean of k out of n samples drawn without repetition. The smallest of equals; n = 1: 1.
std::uint32_t variance_count(double variance, std::uint32_t n, double lambda);
/// The k with the least error[k - 1] + lambda k; the smallest of equals.
std::uint32_t clairvoyant_count(std::span<const float> error, double lambda);

/// Mean over R, G, B of the population variance of each pixel's m x m displayed samples. `samples`:
/// linear, m times as wide and high as the picture. Throws Error(input) where m does not divide it.
std::vector<float> sample_variance(const Image& samples, std::uint32_t m);

class AaLimits {
public:
    /// `reference`: linear, all n samples of every pixel.
    AaLimits(const Image& reference, std::uint32_t n);
    /// The picture with `k` samples in every pixel, 1 <= k < n, of the reference's size.
    void add(std::uint32_t k, const Image& picture);

    /// Knows the variance of each pixel's samples, and no more: the honest limit of a metric.
    /// `variance`: one number per pixel. All k must have been added.
    LimitPoint by_variance(std::span<const float> variance, double lambda) const;
    /// Knows each count's actual error, luck included: out of reach for any metric.
    LimitPoint by_clairvoyance(double lambda) const;

private:
    template <class Count>
    LimitPoint sum(double lambda, Count count) const;

    std::uint32_t n_;
    Image reference_;          ///< displayed
    std::vector<float> error_; ///< [pixel][k - 1]: mean over R, G, B of the squared difference
};

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
#include "samples/chart/aa_limits.hpp"

#include "framework/core/error.hpp"
#include "framework/image_error/image_error.hpp"
#include "framework/image_error/mse.hpp"

#include <algorithm>
#include <cmath>

namespace ockham {

std::uint32_t variance_count(double variance, std::uint32_t n, double lambda) {
    if (n == 1 || variance <= 0) return 1;
    if (lambda <= 0) return n;
    // One sample more pays while v (1/k - 1/(k + 1)) n / (n - 1) > lambda.
    const double ratio = variance * n / ((n - 1) * lambda);
    const double k = std::ceil(-0.5 + std::sqrt(0.25 + ratio));
    return static_cast<std::uint32_t>(std::clamp(k, 1.0, static_cast<double>(n)));
}

std::uint32_t clairvoyant_count(std::span<const float> error, double lambda) {
    std::uint32_t best = 1;
    for (std::uint32_t k = 2; k <= error.size(); ++k) {
        if (double{error[k - 1]} + lambda * k < double{error[best - 1]} + lambda * best) best = k;
    }
    return best;
}

std::vector<float> sample_variance(const Image& samples, std::uint32_t m) {
    const int window = static_cast<int>(m);
    if (samples.width() % window != 0 || samples.height() % window != 0) {
        fail_input(
            "{} x {} samples are not windows of {} x {}", samples.width(), samples.height(), m, m);
    }
    const Image shown = displayed(samples);
    const int width = samples.width() / window, height = samples.height() / window;
    std::vector<float> variance(static_cast<std::size_t>(width) * height);
    for (std::size_t i = 0; i < variance.size(); ++i) {
        const int left = static_cast<int>(i) % width * window;
        const int top = static_cast<int>(i) / width * window;
        double sum = 0;
        for (int c = 0; c < 3; ++c) {
            double mean = 0, squares = 0;
            for (int j = 0; j < window * window; ++j)
                mean += shown.at(left + j % window, top + j / window, c);
            mean /= window * window;
            for (int j = 0; j < window * window; ++j) {
                const double d = shown.at(left + j % window, top + j / window, c) - mean;
                squares += d * d;
            }
            sum += squares / (window * window);
        }
        variance[i] = static_cast<float>(sum / 3);
    }
    return variance;
}

AaLimits::AaLimits(const Image& reference, std::uint32_t n)
    : n_(n), reference_(displayed(reference)), error_(reference.pixels() * n, 0.0f) {}

void AaLimits::add(std::uint32_t k, const Image& picture) {
    check(k >= 1 && k < n_ && picture.pixels() == reference_.pixels(),
        "a picture of the reference's size with fewer samples");
    const Image shown = displayed(picture);
    for (std::size_t i = 0; i < shown.pixels(); ++i) {
        float squares = 0;
        for (int c = 0; c < 3; ++c) {
            const float d = shown.plane(c)[i] - reference_.plane(c)[i];
            squares += d * d;
        }
        error_[i * n_ + k - 1] = squares / 3;
    }
}

template <class Count>
LimitPoint AaLimits::sum(double lambda, Count count) const {
    const std::size_t pixels = reference_.pixels();
    double samples = 0, squares = 0;
    for (std::size_t i = 0; i < pixels; ++i) {
        const std::uint32_t k = count(i);
        samples += k;
        squares += error_[i * n_ + k - 1];
    }
    const double error = squares / static_cast<double>(pixels);
    return {lambda, 100.0 * samples / (static_cast<double>(pixels) * n_), error, psnr(error)};
}

LimitPoint AaLimits::by_variance(std::span<const float> variance, double lambda) const {
    check(variance.size() == reference_.pixels(), "one variance per pixel");
    return sum(lambda, [&](std::size_t i) { return variance_count(variance[i], n_, lambda); });
}

LimitPoint AaLimits::by_clairvoyance(double lambda) const {
    const std::span<const float> all(error_);
    return sum(
        lambda, [&](std::size_t i) { return clairvoyant_count(all.subspan(i * n_, n_), lambda); });
}

} // namespace ockham

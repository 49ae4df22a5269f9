// SPDX-License-Identifier: Apache-2.0
#include "framework/image_error/ssim.hpp"

#include "framework/core/error.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace ockham {
namespace {

constexpr int kRadius = 5;
constexpr double kSigma = 1.5;
constexpr double kC1 = 0.01 * 0.01;
constexpr double kC2 = 0.03 * 0.03;

/// Doubles, because variance is the small difference of two large means.
struct Plane {
    int width = 0, height = 0;
    std::vector<double> values;
    double* row(int y) { return values.data() + std::ptrdiff_t{y} * width; }
    const double* row(int y) const { return values.data() + std::ptrdiff_t{y} * width; }
};

std::array<double, 2 * kRadius + 1> gaussian() {
    std::array<double, 2 * kRadius + 1> weights{};
    double sum = 0;
    for (int i = -kRadius; i <= kRadius; ++i) {
        sum += weights[static_cast<std::size_t>(i + kRadius)] =
            std::exp(-0.5 * i * i / (kSigma * kSigma));
    }
    for (double& weight : weights) weight /= sum;
    return weights;
}

/// Index into [0,size) of a position mirrored at the edges as often as needed: c b a | a b c.
int mirror(int i, int size) {
    const int period = 2 * size;
    const int wrapped = ((i % period) + period) % period;
    return wrapped < size ? wrapped : period - 1 - wrapped;
}

Plane blur(const Plane& in) {
    static const auto kWeights = gaussian();
    Plane across{in.width, in.height, std::vector<double>(in.values.size())};
    std::vector<double> padded(static_cast<std::size_t>(in.width + 2 * kRadius));
    for (int y = 0; y < in.height; ++y) {
        for (int x = -kRadius; x < in.width + kRadius; ++x) {
            padded[static_cast<std::size_t>(x + kRadius)] = in.row(y)[mirror(x, in.width)];
        }
        double* out = across.row(y);
        for (std::size_t t = 0; t < kWeights.size(); ++t) {
            for (int x = 0; x < in.width; ++x)
                out[x] += kWeights[t] * padded[t + static_cast<std::size_t>(x)];
        }
    }
    Plane out{in.width, in.height, std::vector<double>(in.values.size())};
    for (int y = 0; y < in.height; ++y) {
        for (int t = -kRadius; t <= kRadius; ++t) {
            const double weight = kWeights[static_cast<std::size_t>(t + kRadius)];
            const double* source = across.row(mirror(y + t, in.height));
            for (int x = 0; x < in.width; ++x) out.row(y)[x] += weight * source[x];
        }
    }
    return out;
}

Plane product(const Plane& a, const Plane& b) {
    Plane out = a;
    for (std::size_t i = 0; i < out.values.size(); ++i) out.values[i] *= b.values[i];
    return out;
}

double mean_ssim(const Plane& a, const Plane& b) {
    const Plane mean_a = blur(a), mean_b = blur(b);
    const Plane square_a = blur(product(a, a)), square_b = blur(product(b, b));
    const Plane mixed = blur(product(a, b));
    const int border_x = a.width > 2 * kRadius ? kRadius : 0;
    const int border_y = a.height > 2 * kRadius ? kRadius : 0;
    double sum = 0;
    for (int y = border_y; y < a.height - border_y; ++y) {
        for (int x = border_x; x < a.width - border_x; ++x) {
            const double ma = mean_a.row(y)[x], mb = mean_b.row(y)[x];
            const double variance_a = square_a.row(y)[x] - ma * ma;
            const double variance_b = square_b.row(y)[x] - mb * mb;
            const double covariance = mixed.row(y)[x] - ma * mb;
            sum += (2 * ma * mb + kC1) * (2 * covariance + kC2) /
                   ((ma * ma + mb * mb + kC1) * (variance_a + variance_b + kC2));
        }
    }
    return sum / (static_cast<double>(a.width - 2 * border_x) * (a.height - 2 * border_y));
}

Plane weighted(const Image& image, double r, double g, double b) {
    Plane out{image.width(), image.height(), std::vector<double>(image.pixels())};
    const std::span<const float> red = image.plane("R"), green = image.plane("G"),
                                 blue = image.plane("B");
    for (std::size_t i = 0; i < out.values.size(); ++i) {
        out.values[i] = r * double{red[i]} + g * double{green[i]} + b * double{blue[i]};
    }
    return out;
}

double mean_ssim(const Image& test, const Image& reference, double r, double g, double b) {
    check(!test.empty() && test.width() == reference.width() && test.height() == reference.height(),
        "compared images have one size");
    return mean_ssim(weighted(test, r, g, b), weighted(reference, r, g, b));
}

} // namespace

double ssim_luma(const Image& test, const Image& reference) {
    return mean_ssim(test, reference, 0.2989, 0.5870, 0.1140);
}

double ssim_rgb(const Image& test, const Image& reference) {
    return (mean_ssim(test, reference, 1, 0, 0) + mean_ssim(test, reference, 0, 1, 0) +
               mean_ssim(test, reference, 0, 0, 1)) /
           3.0;
}

} // namespace ockham

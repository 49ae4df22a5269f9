// SPDX-License-Identifier: Apache-2.0
#include "framework/image_error/mse.hpp"

#include "framework/core/error.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>

namespace ockham {
namespace {

constexpr std::array<std::string_view, 3> kColors{"R", "G", "B"};
constexpr double kRelativeEpsilon = 0.01;

void check_sizes(const Image& test, const Image& reference) {
    check(!test.empty() && test.width() == reference.width() && test.height() == reference.height(),
        "compared images have one size");
}

/// Mean of error(test, reference) over pixels and R, G, B.
template <class Error>
double mean_over_colors(const Image& test, const Image& reference, Error error) {
    check_sizes(test, reference);
    double sum = 0;
    for (const std::string_view color : kColors) {
        const std::span<const float> a = test.plane(color), b = reference.plane(color);
        for (std::size_t i = 0; i < a.size(); ++i) sum += error(double{a[i]}, double{b[i]});
    }
    return sum / (3.0 * static_cast<double>(test.pixels()));
}

} // namespace

double mse(const Image& test, const Image& reference) {
    return mean_over_colors(test, reference, [](double a, double b) { return (a - b) * (a - b); });
}

double psnr(double mse) {
    return mse > 0 ? -10.0 * std::log10(mse) : std::numeric_limits<double>::infinity();
}

double relative_mse(const Image& test, const Image& reference) {
    return mean_over_colors(test, reference,
        [](double a, double b) { return (a - b) * (a - b) / (b * b + kRelativeEpsilon); });
}

std::vector<float> absolute_error(const Image& test, const Image& reference) {
    check_sizes(test, reference);
    std::vector<float> errors(test.pixels(), 0.0f);
    for (const std::string_view color : kColors) {
        const std::span<const float> a = test.plane(color), b = reference.plane(color);
        for (std::size_t i = 0; i < a.size(); ++i) {
            errors[i] = std::max(errors[i], std::abs(a[i] - b[i]));
        }
    }
    return errors;
}

double quantile(std::vector<float> values, double fraction) {
    check(fraction > 0 && fraction <= 1, "a quantile's fraction is in (0,1]");
    if (values.empty()) return 0;
    const auto rank =
        static_cast<std::size_t>(std::ceil(fraction * static_cast<double>(values.size())));
    const auto nth =
        values.begin() + static_cast<std::ptrdiff_t>(std::max<std::size_t>(rank, 1) - 1);
    std::nth_element(values.begin(), nth, values.end());
    return *nth;
}

} // namespace ockham

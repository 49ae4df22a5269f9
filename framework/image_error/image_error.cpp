// SPDX-License-Identifier: Apache-2.0
#include "framework/image_error/image_error.hpp"

#include "framework/core/error.hpp"
#include "framework/image_error/mse.hpp"
#include "framework/image_error/ssim.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <string_view>
#include <vector>

namespace ockham {
namespace {

constexpr std::array<std::string_view, 3> kColors{"R", "G", "B"};

/// Linear values whose relative squared error, as relative_mse counts it, is exactly 1.
constexpr float kBadTest = 0.1f;
constexpr float kBadReference = 0.0f;

/// A copy of R, G, B alone.
Image colors_of(const Image& image, std::string_view what) {
    Image colors(std::max(image.width(), 1), std::max(image.height(), 1), {"R", "G", "B"});
    for (const std::string_view color : kColors) {
        if (!image.find(color)) {
            fail_input("cannot compare: the {} has no channel {}, only {}", what, color,
                fmt::join(image.channels(), ", "));
        }
        std::ranges::copy(image.plane(color), colors.plane(color).begin());
    }
    return colors;
}

std::vector<std::size_t> non_finite_pixels(const Image& image) {
    std::vector<std::size_t> pixels;
    const std::span<const float> r = image.plane("R"), g = image.plane("G"), b = image.plane("B");
    for (std::size_t i = 0; i < r.size(); ++i) {
        if (!std::isfinite(r[i]) || !std::isfinite(g[i]) || !std::isfinite(b[i])) {
            pixels.push_back(i);
        }
    }
    return pixels;
}

void paint(Image& image, const std::vector<std::size_t>& pixels, float value) {
    for (const std::string_view color : kColors) {
        const std::span<float> plane = image.plane(color);
        for (const std::size_t i : pixels) plane[i] = value;
    }
}

/// Sets the map to 1 at these pixels.
void count_as_one(Flip& flip, const std::vector<std::size_t>& pixels) {
    if (pixels.empty()) return;
    const std::span<float> map = flip.map.plane(0);
    for (const std::size_t i : pixels) map[i] = 1.0f;
    flip.max = 1.0;
    flip.mean = std::accumulate(map.begin(), map.end(), 0.0) / static_cast<double>(map.size());
}

bool exceeds_one(const Image& image) {
    return std::ranges::any_of(kColors, [&](std::string_view color) {
        return std::ranges::any_of(image.plane(color), [](float value) { return value > 1.0f; });
    });
}

} // namespace

Image displayed(const Image& linear) {
    Image encoded = colors_of(linear, "picture to display");
    for (const std::string_view color : kColors) {
        std::ranges::transform(encoded.plane(color), encoded.plane(color).begin(), srgb_encode);
    }
    return encoded;
}

ImageError image_error(const Image& test, const Image& reference) {
    if (test.width() != reference.width() || test.height() != reference.height() || test.empty()) {
        fail_input("cannot compare: the test picture has {} x {} pixels, the reference {} x {}",
            test.width(), test.height(), reference.width(), reference.height());
    }
    Image linear_test = colors_of(test, "test picture");
    Image linear_reference = colors_of(reference, "reference");
    if (const auto bad = non_finite_pixels(linear_reference); !bad.empty()) {
        fail_input("cannot compare: {} of {} pixels of the reference are not finite (the first at "
                   "x {}, y {})",
            bad.size(), reference.pixels(), bad[0] % static_cast<std::size_t>(reference.width()),
            bad[0] / static_cast<std::size_t>(reference.width()));
    }
    const std::vector<std::size_t> bad = non_finite_pixels(linear_test);
    paint(linear_test, bad, kBadTest);
    paint(linear_reference, bad, kBadReference);
    Image displayed_test = displayed(linear_test),
          displayed_reference = displayed(linear_reference);
    paint(displayed_test, bad, 1.0f);
    paint(displayed_reference, bad, 0.0f);

    ImageError error;
    error.non_finite = bad.size();
    error.mse = mse(displayed_test, displayed_reference);
    error.psnr = psnr(error.mse);
    error.ssim = ssim_luma(displayed_test, displayed_reference);
    error.ssim_rgb = ssim_rgb(displayed_test, displayed_reference);
    const std::vector<float> absolute = absolute_error(displayed_test, displayed_reference);
    error.max = *std::ranges::max_element(absolute);
    error.p99 = quantile(absolute, 0.99);
    error.map = Image(test.width(), test.height(), {"error"});
    std::ranges::copy(absolute, error.map.plane(0).begin());
    error.relmse = relative_mse(linear_test, linear_reference);
    error.flip = flip(linear_test, linear_reference);
    count_as_one(error.flip, bad);
    error.hdr = exceeds_one(linear_test) || exceeds_one(linear_reference);
    if (error.hdr) {
        error.hdr_flip = hdr_flip(linear_test, linear_reference);
        count_as_one(*error.hdr_flip, bad);
    }
    return error;
}

} // namespace ockham

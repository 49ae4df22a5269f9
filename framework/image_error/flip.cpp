// SPDX-License-Identifier: Apache-2.0
#include "framework/image_error/flip.hpp"

#include "framework/core/error.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <vector>

namespace ockham {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kPixelsPerDegree = 0.7 * 3840.0 / 0.7 * kPi / 180.0;
constexpr double kFeatureWidth = 0.082; // degrees
constexpr float kColorExponent = 0.7f;
constexpr float kColorKnee = 0.4f;       // share of the largest colour difference ...
constexpr float kColorKneeError = 0.95f; // ... that is mapped up to this error

using Color = std::array<float, 3>;
using Plane = std::vector<float>;

/// Three planes of one size: linear RGB, YCxCz or Lab.
struct Planes {
    int width = 0, height = 0;
    std::array<Plane, 3> channels;

    Color at(std::size_t i) const { return {channels[0][i], channels[1][i], channels[2][i]}; }
    void set(std::size_t i, const Color& color) {
        for (std::size_t c = 0; c < 3; ++c) channels[c][i] = color[c];
    }
};

// --- Colour spaces (Rec. 709 primaries; white is RGB 1, 1, 1) --------------------------------

/// X, Y, Z of linear RGB, each divided by that of white.
Color relative_xyz(const Color& rgb) {
    const auto [r, g, b] = rgb;
    return {0.43389539f * r + 0.37624237f * g + 0.18986224f * b,
        0.21263682f * r + 0.71518298f * g + 0.07218020f * b,
        0.01775242f * r + 0.10946563f * g + 0.87278195f * b};
}

Color ycxcz(const Color& rgb) {
    const auto [x, y, z] = relative_xyz(rgb);
    return {116.0f * y - 16.0f, 500.0f * (x - y), 200.0f * (y - z)};
}

/// The inverse of ycxcz.
Color rgb_of_ycxcz(const Color& color) {
    const float y = (color[0] + 16.0f) / 116.0f;
    const float x = y + color[1] / 500.0f;
    const float z = y - color[2] / 200.0f;
    return {3.08034199f * x - 1.53739897f * y - 0.54294302f * z,
        -0.92117840f * x + 1.87592998f * y + 0.04524841f * z,
        0.05288129f * x - 0.20401121f * y + 1.15112991f * z};
}

/// CIELab with a and b scaled by lightness, as Hunt observed: 0.01 L a, 0.01 L b.
Color hunt_lab(const Color& rgb) {
    constexpr float kDelta = 6.0f / 29.0f;
    const auto curve = [](float t) {
        return t > kDelta * kDelta * kDelta ? std::cbrt(t)
                                            : t / (3.0f * kDelta * kDelta) + 4.0f / 29.0f;
    };
    const auto [x, y, z] = relative_xyz(rgb);
    const float fx = curve(x), fy = curve(y), fz = curve(z);
    const float lightness = 116.0f * fy - 16.0f;
    return {
        lightness, 0.01f * lightness * 500.0f * (fx - fy), 0.01f * lightness * 200.0f * (fy - fz)};
}

float hyab(const Color& a, const Color& b) {
    const float da = a[1] - b[1], db = a[2] - b[2];
    return std::abs(a[0] - b[0]) + std::sqrt(da * da + db * db);
}

// --- Filters ----------------------------------------------------------------------------------

/// Weights at offsets -radius .. radius.
using Kernel = std::vector<float>;

template <class Function>
Kernel sample_kernel(int radius, Function function) {
    Kernel kernel;
    for (int i = -radius; i <= radius; ++i)
        kernel.push_back(static_cast<float>(function(double(i))));
    return kernel;
}

double sum_of(const Kernel& kernel) { return std::accumulate(kernel.begin(), kernel.end(), 0.0); }

/// Scales the positive weights to the sum 1 and the negative ones to -1.
Kernel normalized_by_sign(Kernel kernel) {
    double positive = 0, negative = 0;
    for (const float weight : kernel) (weight > 0 ? positive : negative) += std::abs(weight);
    for (float& weight : kernel) {
        weight = static_cast<float>(weight / (weight > 0 ? positive : negative));
    }
    return kernel;
}

/// Filters along x, then along y, with the edge pixels repeated outwards.
Plane filter(const Plane& in, int width, int height, const Kernel& along_x, const Kernel& along_y) {
    const auto columns = static_cast<std::size_t>(width);
    const int radius_x = static_cast<int>(along_x.size()) / 2;
    const int radius_y = static_cast<int>(along_y.size()) / 2;
    Plane across(in.size(), 0.0f);
    std::vector<float> padded(columns + along_x.size() - 1);
    for (int y = 0; y < height; ++y) {
        const float* row = in.data() + static_cast<std::size_t>(y) * columns;
        std::fill_n(padded.begin(), radius_x, row[0]);
        std::copy_n(row, columns, padded.begin() + radius_x);
        std::fill(padded.begin() + radius_x + width, padded.end(), row[width - 1]);
        float* out = across.data() + static_cast<std::size_t>(y) * columns;
        for (std::size_t t = 0; t < along_x.size(); ++t) {
            const float weight = along_x[t];
            const float* source = padded.data() + t;
            for (std::size_t x = 0; x < columns; ++x) out[x] += weight * source[x];
        }
    }
    Plane result(in.size(), 0.0f);
    for (int y = 0; y < height; ++y) {
        float* out = result.data() + static_cast<std::size_t>(y) * columns;
        for (int t = -radius_y; t <= radius_y; ++t) {
            const float weight = along_y[static_cast<std::size_t>(t + radius_y)];
            const auto from = static_cast<std::size_t>(std::clamp(y + t, 0, height - 1));
            const float* source = across.data() + from * columns;
            for (std::size_t x = 0; x < columns; ++x) out[x] += weight * source[x];
        }
    }
    return result;
}

/// One term a sqrt(pi/b) exp(-pi^2 d^2 / b), d in degrees, of a contrast sensitivity function.
struct CsfTerm {
    double a, b;
};

/// The channel seen through a contrast sensitivity function: a sum of Gaussians, each separable,
/// normalised together.
Plane see(const Plane& in, int width, int height, const std::vector<CsfTerm>& terms) {
    // The widest term of all channels decides the radius, for all of them.
    static const int kRadius =
        static_cast<int>(std::ceil(3.0 * std::sqrt(0.04 / (2.0 * kPi * kPi)) * kPixelsPerDegree));
    std::vector<Kernel> kernels;
    std::vector<double> weights;
    for (const CsfTerm& term : terms) {
        kernels.push_back(sample_kernel(kRadius, [&](double i) {
            const double degrees = i / kPixelsPerDegree;
            return std::exp(-kPi * kPi * degrees * degrees / term.b);
        }));
        const double sum = sum_of(kernels.back());
        for (float& weight : kernels.back()) weight = static_cast<float>(weight / sum);
        weights.push_back(term.a * std::sqrt(kPi / term.b) * sum * sum);
    }
    const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
    Plane out(in.size(), 0.0f);
    for (std::size_t t = 0; t < terms.size(); ++t) {
        const Plane part = filter(in, width, height, kernels[t], kernels[t]);
        const auto weight = static_cast<float>(weights[t] / total);
        for (std::size_t i = 0; i < out.size(); ++i) out[i] += weight * part[i];
    }
    return out;
}

// --- The two pipelines ------------------------------------------------------------------------

/// What a viewer sees of a picture: YCxCz in, Hunt-adjusted Lab out.
Planes seen_lab(const Planes& in) {
    Planes out{in.width, in.height,
        {see(in.channels[0], in.width, in.height, {{1.0, 0.0047}}),
            see(in.channels[1], in.width, in.height, {{1.0, 0.0053}}),
            see(in.channels[2], in.width, in.height, {{34.1, 0.04}, {13.5, 0.025}})}};
    for (std::size_t i = 0; i < out.channels[0].size(); ++i) {
        Color rgb = rgb_of_ycxcz(out.at(i));
        for (float& value : rgb) value = std::clamp(value, 0.0f, 1.0f);
        out.set(i, hunt_lab(rgb));
    }
    return out;
}

/// HyAB distance, compressed and spread over [0,1].
float color_difference(const Color& a, const Color& b) {
    static const float kLargest =
        std::pow(hyab(hunt_lab({0, 1, 0}), hunt_lab({0, 0, 1})), kColorExponent);
    const float knee = kColorKnee * kLargest;
    const float distance = std::pow(hyab(a, b), kColorExponent);
    if (distance < knee) return kColorKneeError / knee * distance;
    return kColorKneeError + (distance - knee) / (kLargest - knee) * (1.0f - kColorKneeError);
}

/// Strength of edges and of points at every pixel of a luminance plane.
struct Features {
    Plane edges, points;
};

Plane magnitude(Plane x, const Plane& y) {
    for (std::size_t i = 0; i < x.size(); ++i) x[i] = std::sqrt(x[i] * x[i] + y[i] * y[i]);
    return x;
}

Features features(const Planes& in) {
    constexpr double kSigma = 0.5 * kFeatureWidth * kPixelsPerDegree;
    static const int kRadius = static_cast<int>(std::ceil(3.0 * kSigma));
    const auto gaussian = [](double i) { return std::exp(-i * i / (2.0 * kSigma * kSigma)); };
    static const Kernel kSmooth = normalized_by_sign(sample_kernel(kRadius, gaussian));
    static const Kernel kEdge =
        normalized_by_sign(sample_kernel(kRadius, [&](double i) { return -i * gaussian(i); }));
    static const Kernel kPoint = normalized_by_sign(sample_kernel(
        kRadius, [&](double i) { return (i * i / (kSigma * kSigma) - 1.0) * gaussian(i); }));

    Plane luminance = in.channels[0];
    for (float& value : luminance) value = (value + 16.0f) / 116.0f;
    const auto run = [&](const Kernel& x, const Kernel& y) {
        return filter(luminance, in.width, in.height, x, y);
    };
    return {magnitude(run(kEdge, kSmooth), run(kSmooth, kEdge)),
        magnitude(run(kPoint, kSmooth), run(kSmooth, kPoint))};
}

/// The FLIP map of two pictures of linear RGB in [0,1].
Plane flip_map(Planes test, Planes reference) {
    for (Planes* planes : {&test, &reference}) {
        for (std::size_t i = 0; i < planes->channels[0].size(); ++i) {
            planes->set(i, ycxcz(planes->at(i)));
        }
    }
    const Planes seen_test = seen_lab(test), seen_reference = seen_lab(reference);
    const Features test_features = features(test), reference_features = features(reference);
    Plane map(test.channels[0].size());
    for (std::size_t i = 0; i < map.size(); ++i) {
        const float color = color_difference(seen_test.at(i), seen_reference.at(i));
        const float feature =
            std::max(std::abs(test_features.edges[i] - reference_features.edges[i]),
                std::abs(test_features.points[i] - reference_features.points[i]));
        const float exponent = 1.0f - std::sqrt(feature / std::numbers::sqrt2_v<float>);
        map[i] = std::pow(color, exponent);
    }
    return map;
}

/// R, G, B through `function`, value by value.
template <class Function>
Planes planes_of(const Image& image, Function function) {
    Planes planes{image.width(), image.height(), {}};
    constexpr std::array<const char*, 3> kNames{"R", "G", "B"};
    for (std::size_t c = 0; c < 3; ++c) {
        const std::span<const float> from = image.plane(kNames[c]);
        planes.channels[c].resize(from.size());
        std::transform(from.begin(), from.end(), planes.channels[c].begin(), function);
    }
    return planes;
}

void check_sizes(const Image& test, const Image& reference) {
    check(!test.empty() && test.width() == reference.width() && test.height() == reference.height(),
        "compared images have one size");
}

void summarize(Flip& result, const Plane& map, const Image& like) {
    result.map = Image(like.width(), like.height(), {"flip"});
    std::copy(map.begin(), map.end(), result.map.plane(0).begin());
    result.mean = std::accumulate(map.begin(), map.end(), 0.0) / static_cast<double>(map.size());
    result.max = *std::max_element(map.begin(), map.end());
}

// The ACES fit, x (0.9036 x + 0.018) / (x (0.8748 x + 0.354) + 0.14).
constexpr double kAces[] = {0.9036, 0.018, 0.8748, 0.354, 0.14};
constexpr double kSaturated = 0.85; // a tone-mapped value above this counts as too bright

float aces(double linear) {
    const double x = std::clamp(linear, 0.0, 1e4); // 1 is reached long before
    const double y = x * (kAces[0] * x + kAces[1]) / (x * (kAces[2] * x + kAces[3]) + kAces[4]);
    return static_cast<float>(std::min(y, 1.0));
}

/// The linear value that the tone curve maps to kSaturated: the positive root of a quadratic.
double saturating_value() {
    const double a = kAces[0] - kSaturated * kAces[2];
    const double b = kAces[1] - kSaturated * kAces[3];
    const double c = -kSaturated * kAces[4];
    return (-b + std::sqrt(b * b - 4.0 * a * c)) / (2.0 * a);
}

} // namespace

Flip flip(const Image& test, const Image& reference) {
    check_sizes(test, reference);
    const auto clamp = [](float value) { return std::clamp(value, 0.0f, 1.0f); };
    Flip result;
    summarize(result, flip_map(planes_of(test, clamp), planes_of(reference, clamp)), test);
    return result;
}

HdrFlip hdr_flip(const Image& test, const Image& reference) {
    check_sizes(test, reference);
    const Planes colors = planes_of(reference, [](float value) { return value; });
    Plane luminance(reference.pixels());
    for (std::size_t i = 0; i < luminance.size(); ++i) {
        luminance[i] =
            std::max(relative_xyz(colors.at(i))[1], std::numeric_limits<float>::epsilon());
    }
    const double brightest = *std::max_element(luminance.begin(), luminance.end());
    const auto middle = luminance.begin() + static_cast<std::ptrdiff_t>((luminance.size() - 1) / 2);
    std::nth_element(luminance.begin(), middle, luminance.end());

    HdrFlip result;
    result.start_exposure = std::log2(saturating_value() / brightest);
    result.stop_exposure = std::log2(saturating_value() / double{*middle});
    const double stops = result.stop_exposure - result.start_exposure;
    result.exposures = std::max(2, static_cast<int>(std::ceil(stops)));
    Plane worst(reference.pixels(), 0.0f);
    for (int e = 0; e < result.exposures; ++e) {
        const double scale = std::exp2(result.start_exposure + stops * e / (result.exposures - 1));
        const auto expose = [&](float value) { return aces(double{value} * scale); };
        const Plane map = flip_map(planes_of(test, expose), planes_of(reference, expose));
        for (std::size_t i = 0; i < map.size(); ++i) worst[i] = std::max(worst[i], map[i]);
    }
    summarize(result, worst, test);
    return result;
}

} // namespace ockham

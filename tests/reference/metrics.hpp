// SPDX-License-Identifier: Apache-2.0
// Plain C++ twin of shaders/surface/metrics.comp, in double precision: what the formulas of
// Hollaender et al. 2013, section 3.1, ask for where nothing is lost to rounding.
#pragma once

#include "passes/surface/metrics.hpp"

#include <glm/glm.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace ockham::reference {

/// One window: view depths of all samples, normals of those that hit, luma of S at the four
/// direct neighbours.
struct Window {
    std::span<const double> depths;
    std::span<const glm::dvec3> normals;
    std::array<double, 4> luma{};
};

/// Mean squared deviation by two passes: no cancellation, 0 for equal values.
inline double two_pass_variance(std::span<const double> values) {
    double mean = 0;
    for (const double v : values) mean += v;
    mean /= static_cast<double>(values.size());
    double sum = 0;
    for (const double v : values) sum += (v - mean) * (v - mean);
    return sum / static_cast<double>(values.size());
}

/// The same by difference of fp32 sums, as the paper's formula reads.
inline float naive_variance(std::span<const float> values) {
    float sum = 0, squares = 0;
    for (const float v : values) {
        sum += v;
        squares += v * v;
    }
    const auto n = static_cast<float>(values.size());
    return squares / n - sum / n * (sum / n);
}

/// sqrt(1 - min |mean . normal|), the mean normalised; 0 where the mean vanishes.
inline double normal_cone(std::span<const glm::dvec3> normals) {
    glm::dvec3 sum(0.0);
    for (const glm::dvec3& n : normals) sum += n;
    if (glm::length(sum) == 0.0) return 0.0;
    double smallest = 1.0;
    for (const glm::dvec3& n : normals) {
        smallest = std::min(smallest, std::abs(glm::dot(glm::normalize(sum), n)));
    }
    return std::sqrt(1.0 - smallest);
}

/// Range of luma, 0 inside the dead zone.
inline double luma_range(const std::array<double, 4>& luma, const MetricsParams& params) {
    const double high = *std::max_element(luma.begin(), luma.end());
    const double range = high - *std::min_element(luma.begin(), luma.end());
    return range < std::max<double>(params.range_min, high * params.range_edge) ? 0.0 : range;
}

/// Samples asked for by depth, normals and shading, not yet rounded up.
inline std::array<double, 3> wanted_samples(const Window& window, const MetricsParams& params) {
    return {params.depth_weight * two_pass_variance(window.depths),
        params.normal_weight * normal_cone(window.normals),
        params.shading_weight * luma_range(window.luma, params)};
}

inline int sample_count(double wanted, int n) {
    return static_cast<int>(std::clamp(std::ceil(wanted), 1.0, static_cast<double>(n)));
}

} // namespace ockham::reference

// SPDX-License-Identifier: Apache-2.0
// Plain C++ twin of shaders/surface/clusters.comp: which surface of its window each sample lies on.
#pragma once

#include <glm/glm.hpp>

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace ockham::reference {

struct WindowSample {
    bool hit = false;
    double depth = 0; ///< stored
    glm::dvec2 slope{0.0};
    std::uint32_t material = 0;
    glm::dvec2 offset{0.0}; ///< in the window, samples
};

/// Samples in the order in which they are taken; `pixel`: width of a pixel at view depth 1.
inline std::vector<std::uint32_t> cluster_labels(
    std::span<const WindowSample> samples, double pixel) {
    std::vector<WindowSample> firsts;
    std::vector<std::uint32_t> labels;
    for (const WindowSample& s : samples) {
        std::uint32_t label = 3;
        for (std::uint32_t c = 0; c < firsts.size() && label == 3; ++c) {
            const WindowSample& first = firsts[c];
            const double plane = first.depth + glm::dot(first.slope, s.offset - first.offset);
            const double slope = std::abs(first.slope.x) + std::abs(first.slope.y);
            const bool on_plane =
                std::abs(s.depth - plane) <= 0.3 * pixel * first.depth + slope / 512;
            if (s.hit ? first.hit && s.material == first.material && on_plane : !first.hit)
                label = c;
        }
        if (label == 3 && firsts.size() < 3) {
            label = static_cast<std::uint32_t>(firsts.size());
            firsts.push_back(s);
        }
        labels.push_back(label);
    }
    return labels;
}

/// sqrt(1 / |mean| - 1), at most 1; 0 for no normals.
inline double normal_spread(std::span<const glm::dvec3> normals) {
    if (normals.empty()) return 0;
    glm::dvec3 sum(0.0);
    for (const glm::dvec3& n : normals) sum += n;
    const double r = glm::length(sum) / static_cast<double>(normals.size());
    return r <= 0.5 ? 1.0 : std::sqrt(std::max(1 / r - 1, 0.0));
}

} // namespace ockham::reference

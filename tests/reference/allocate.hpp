// SPDX-License-Identifier: Apache-2.0
// Plain C++ twin of shaders/surface/variance.glsl.
#pragma once

#include <glm/glm.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

namespace ockham::reference {

inline glm::vec2 pack_variance(float within, float between, std::uint32_t surfaces) {
    const std::uint32_t bits = std::max(
        std::bit_cast<std::uint32_t>(between / static_cast<float>(std::max(surfaces, 2u) - 1u)) &
            ~3u,
        0x800000u);
    return {within, surfaces > 1 ? std::bit_cast<float>(bits | (surfaces - 1u)) : 0.0f};
}

inline std::uint32_t surface_count(glm::vec2 variance) {
    return (std::bit_cast<std::uint32_t>(variance.y) & 3u) + 1u;
}

inline std::uint32_t allocated_samples(glm::vec2 variance, double lambda, std::uint32_t n) {
    if (lambda <= 0) return n;
    const double k = std::floor(0.5 + std::sqrt(0.25 + double{variance.x} / lambda));
    const std::uint32_t surfaces = variance.y >= lambda ? std::min(surface_count(variance), n) : 1u;
    return std::max(static_cast<std::uint32_t>(std::clamp(k, 1.0, double(n))), surfaces);
}

} // namespace ockham::reference

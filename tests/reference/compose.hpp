// SPDX-License-Identifier: Apache-2.0
// shaders/volume/compose.comp along one ray, in double precision and without jitter: front to back
// through cells with a majorant each. Called by tests.
#pragma once

#include <glm/glm.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

namespace ockham::reference {

struct MediumPoint {
    double sigma_t = 0;
    glm::dvec3 albedo{0.0}, emitted{0.0};
};

/// Ends at `exit`; nothing in it is denser than the majorant.
struct RayCell {
    double exit = 0, majorant = 0;
};

struct Composed {
    glm::dvec3 radiance{0.0};
    double alpha = 0;
};

/// `medium`: MediumPoint(t). `longest`: of a step, in units of t, halved and so on up to an eighth
/// where the optical depth under the majorant would exceed `depth`. `light`: what is scattered in
/// from the cache everywhere, but for albedo.
template <class Medium>
Composed compose(const std::vector<RayCell>& cells, double t, Medium medium, double longest,
    double depth, glm::dvec3 light, glm::dvec3 environment) {
    constexpr int kSteps = 4;
    constexpr double kOpaque = 1.0 / 512.0;
    glm::dvec3 radiance(0.0);
    double transmittance = 1;
    for (const RayCell& cell : cells) {
        while (cell.majorant > 0 && cell.exit > t && transmittance >= kOpaque) {
            const double step = std::max(std::min(longest, depth / cell.majorant), longest / 8.0);
            const double looks =
                std::max(std::ceil((cell.exit - t) / (kSteps * step) - 0.001), 1.0);
            const double h = (cell.exit - t) / looks / kSteps;
            for (int i = 0; i < kSteps; ++i) {
                const MediumPoint m = medium(t + (i + 0.5) * h);
                const double opacity = 1.0 - std::exp(-m.sigma_t * h);
                radiance +=
                    transmittance * opacity * (m.albedo * light + (1.0 - m.albedo) * m.emitted);
                transmittance *= 1.0 - opacity;
            }
            t = looks > 1 ? t + kSteps * h : cell.exit;
        }
        t = std::max(t, cell.exit);
    }
    if (transmittance < kOpaque) return {radiance / (1.0 - transmittance), 1.0};
    return {radiance + transmittance * environment, 1.0 - transmittance};
}

} // namespace ockham::reference

// SPDX-License-Identifier: Apache-2.0
// Radiance in a medium by analog Monte Carlo in double precision: photons' histories backwards,
// collision by collision. Written from the transport equation, not from the kernel: free flights
// invert the optical depth, found by quadrature, in place of majorants and tentative collisions;
// absorption ends a history in place of weights and roulette; colours are traced one by one.
#pragma once

#include "framework/scene/transfer_function.hpp"
#include "framework/scene/volume.hpp"
#include "framework/scene/volume_view.hpp"

#include <glm/glm.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace ockham::reference {

class AnalogTracer {
public:
    /// `volume` must outlive the tracer. Surfaces and environment maps are not its business.
    AnalogTracer(const Volume& volume, const TransferFunction& transfer, const VolumeView& view)
        : volume_(volume), table_(tabulate(transfer, volume)), place_(place_of(volume)),
          inverse_(glm::inverse(place_.edges)), view_(view),
          to_light_(-glm::normalize(glm::dvec3(view.light_direction))) {
        for (int axis = 0; axis < 3; ++axis)
            step_ = std::min(step_, 0.25 * glm::length(place_.edges[axis]) / volume.dims[axis]);
    }

    /// One history, seen from `origin` in `direction` (world, unit), in one colour channel.
    double history(
        glm::dvec3 origin, glm::dvec3 direction, int channel, std::mt19937_64& random) const {
        std::uniform_real_distribution<double> uniform(0.0, 1.0);
        const double environment = view_.environment[channel];
        const double irradiance = view_.light_irradiance[channel];
        const auto [near, far] = inside(origin, direction);
        if (near >= far) return environment;
        glm::dvec3 x = origin + near * direction;
        double light = 0;
        for (std::uint32_t scatterings = 0;;) {
            const double end = inside(x, direction).far;
            const double t = flight(x, direction, end, -std::log(1 - uniform(random)));
            if (t == kNever) return light + environment;
            x += t * direction;
            const Point point = at(x);
            if (uniform(random) >= point.albedo[channel]) return light + point.emitted[channel];
            if (++scatterings > view_.max_bounces) return light;
            if (irradiance > 0) {
                light += irradiance * phase(glm::dot(direction, to_light_)) *
                         std::exp(-depth(x, to_light_, inside(x, to_light_).far));
            }
            direction = scatter(direction, uniform(random), uniform(random));
        }
    }

    /// Optical depth from x over a distance: Simpson's rule, four steps a voxel.
    double depth(glm::dvec3 x, glm::dvec3 direction, double distance) const {
        double sum = 0;
        for (double t = 0; t < distance; t += step_)
            sum += depth_of_step(x, direction, t, std::min(step_, distance - t));
        return sum;
    }

private:
    static constexpr double kNever = std::numeric_limits<double>::infinity();
    struct Interval {
        double near, far;
    };
    struct Point {
        double sigma_t;
        glm::dvec3 albedo, emitted;
    };

    /// Part of a ray in box, crop box and clip planes.
    Interval inside(glm::dvec3 origin, glm::dvec3 direction) const {
        Interval part{0, 1e30};
        const auto cut = [&part](double height, double slope) { // kept where height + t slope >= 0
            if (slope > 0) part.near = std::max(part.near, -height / slope);
            if (slope < 0) part.far = std::min(part.far, -height / slope);
            if (slope == 0 && height < 0) part.far = 0;
        };
        const glm::dvec3 o = inverse_ * (origin - place_.corner), d = inverse_ * direction;
        for (int axis = 0; axis < 3; ++axis) {
            cut(o[axis] - view_.crop_min[axis], d[axis]);
            cut(view_.crop_max[axis] - o[axis], -d[axis]);
        }
        for (const glm::vec4& plane : view_.clip_planes) {
            const glm::dvec3 normal(plane);
            cut(glm::dot(normal, origin) + plane.w, glm::dot(normal, direction));
        }
        part.far = std::max(part.far, 0.0);
        return part;
    }

    Point at(glm::dvec3 world) const {
        const double value = volume_.sample(inverse_ * (world - place_.corner));
        const double last = static_cast<double>(table_.entries.size() - 1);
        const double place =
            std::clamp((value - table_.first) / (table_.last - table_.first), 0.0, 1.0) * last;
        const std::size_t i = std::min(static_cast<std::size_t>(place), table_.entries.size() - 2);
        const double fraction = place - static_cast<double>(i);
        const glm::dvec4 row =
            glm::mix(glm::dvec4(table_.entries[i]), glm::dvec4(table_.entries[i + 1]), fraction);
        Point point{view_.density_scale * row.w, double{view_.albedo} * glm::dvec3(row), {}};
        if (!table_.emission.empty()) {
            point.emitted = glm::mix(
                glm::dvec3(table_.emission[i]), glm::dvec3(table_.emission[i + 1]), fraction);
        }
        return point;
    }

    double depth_of_step(glm::dvec3 x, glm::dvec3 direction, double t, double length) const {
        const auto sigma = [&](double s) { return at(x + s * direction).sigma_t; };
        return length / 6 * (sigma(t) + 4 * sigma(t + 0.5 * length) + sigma(t + length));
    }

    /// Where the optical depth reaches `wanted`; kNever if it does not within the distance.
    double flight(glm::dvec3 x, glm::dvec3 direction, double distance, double wanted) const {
        double sum = 0;
        for (double t = 0; t < distance; t += step_) {
            const double length = std::min(step_, distance - t);
            const double more = depth_of_step(x, direction, t, length);
            if (sum + more >= wanted) return t + (wanted - sum) / more * length;
            sum += more;
        }
        return kNever;
    }

    /// Henyey and Greenstein 1941.
    double phase(double cosine) const {
        const double g = view_.phase_g;
        return (1 - g * g) / (4 * std::numbers::pi * std::pow(1 + g * g - 2 * g * cosine, 1.5));
    }
    glm::dvec3 scatter(glm::dvec3 direction, double u, double v) const {
        const double g = view_.phase_g;
        const double k = (1 - g * g) / (1 - g + 2 * g * u);
        const double cosine = std::abs(g) < 1e-6 ? 1 - 2 * u : (1 + g * g - k * k) / (2 * g);
        const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
        const glm::dvec3 aside =
            std::abs(direction.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
        const glm::dvec3 a = glm::normalize(glm::cross(direction, aside));
        const glm::dvec3 b = glm::cross(direction, a);
        const double azimuth = 2 * std::numbers::pi * v;
        return glm::normalize(
            cosine * direction + sine * (std::cos(azimuth) * a + std::sin(azimuth) * b));
    }

    const Volume& volume_;
    TransferTable table_;
    VolumePlace place_;
    glm::dmat3 inverse_;
    VolumeView view_;
    glm::dvec3 to_light_;
    double step_ = 1;
};

} // namespace ockham::reference

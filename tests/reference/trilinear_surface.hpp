// SPDX-License-Identifier: Apache-2.0
// The first crossing of an isovalue along a ray, by brute force in double precision: the trilinear
// field is sampled densely, extrema between samples are sought by golden section, and what they
// bracket is bisected. Knows nothing of cells, cubics or their roots. For tests.
#pragma once

#include <glm/glm.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace ockham::reference {

/// Values at voxel centres (i + 1/2) / dims of unit coordinates, clamped beyond the outermost.
struct TrilinearField {
    glm::ivec3 dims{0};
    std::vector<float> voxels; ///< x fastest

    double voxel(glm::ivec3 at) const {
        const glm::ivec3 inside = glm::clamp(at, glm::ivec3(0), dims - 1);
        const auto index = (std::size_t(inside.z) * std::size_t(dims.y) + std::size_t(inside.y)) *
                               std::size_t(dims.x) +
                           std::size_t(inside.x);
        return double{voxels[index]};
    }
    double at(glm::dvec3 unit) const {
        const glm::dvec3 p = unit * glm::dvec3(dims) - 0.5, low = glm::floor(p), w = p - low;
        const glm::ivec3 cell(low);
        double sum = 0;
        for (int corner = 0; corner < 8; ++corner) {
            const glm::ivec3 aside(corner & 1, corner >> 1 & 1, corner >> 2);
            const glm::dvec3 weights = glm::mix(1.0 - w, w, glm::dvec3(aside));
            sum += weights.x * weights.y * weights.z * voxel(cell + aside);
        }
        return sum;
    }
    /// Per unit coordinate, by differences over a voxel to either side.
    glm::dvec3 gradient(glm::dvec3 unit) const {
        glm::dvec3 g;
        for (int axis = 0; axis < 3; ++axis) {
            glm::dvec3 aside(0.0);
            aside[axis] = 1.0 / dims[axis];
            g[axis] = (at(unit + aside) - at(unit - aside)) * 0.5 * dims[axis];
        }
        return g;
    }
};

struct Crossing {
    bool found = false;
    bool at_start = false; ///< the ray starts at or above an isovalue
    double t = 0;
    std::size_t value = 0; ///< index of the isovalue crossed, or around the start
    /// How near to an isovalue the field comes, up to the hit, where it turns before it, just
    /// passes it, starts or ends: what rounding less than this cannot change.
    double margin = std::numeric_limits<double>::infinity();
};

/// Of o + t d in unit coordinates, over [t0, t1]; `samples` to a voxel.
inline Crossing first_crossing(const TrilinearField& field, const std::vector<double>& values,
    glm::dvec3 o, glm::dvec3 d, double t0, double t1, bool start_solid, double samples = 48) {
    const auto f = [&](double t) { return field.at(o + t * d); };
    const auto side = [&](double v) { // a bit per isovalue
        unsigned bits = 0;
        for (std::size_t i = 0; i < values.size(); ++i) bits |= unsigned{v >= values[i]} << i;
        return bits;
    };
    Crossing out;
    const auto near_miss = [&](double v) {
        for (const double value : values) out.margin = std::min(out.margin, std::abs(v - value));
    };

    double before = f(t0);
    near_miss(before);
    if (start_solid && side(before) != 0) {
        out.found = out.at_start = true;
        out.t = t0;
        for (std::size_t i = 0; i < values.size(); ++i) {
            const bool inside = before >= values[i];
            if (inside && (before < values[out.value] || values[i] > values[out.value]))
                out.value = i;
        }
        return out;
    }
    const auto hit = [&](double low, double high) {
        const unsigned from = side(f(low));
        for (int i = 0; i < 60; ++i) {
            const double middle = 0.5 * (low + high);
            (side(f(middle)) == from ? low : high) = middle;
        }
        const unsigned changed = from ^ side(f(high));
        out.found = true;
        out.t = high;
        while ((changed >> out.value & 1u) == 0) ++out.value;
    };

    const double step = 1 / (samples * glm::length(d * glm::dvec3(field.dims)));
    const auto count = static_cast<std::size_t>(std::ceil((t1 - t0) / step));
    double last = before, now = before, t_last = t0, t_now = t0;
    for (std::size_t i = 1; i <= count + 1; ++i) {
        const double t_next = std::min(t0 + static_cast<double>(i) * step, t1), next = f(t_next);
        // An extremum between the neighbours of `now`, where it may reach an isovalue.
        const double curve = std::abs(now - last) + std::abs(next - now) + 1e-6;
        const bool turns = (now - last) * (next - now) <= 0;
        const bool near = std::any_of(values.begin(), values.end(),
            [&](double value) { return std::abs(now - value) < 2 * curve; });
        if (turns && near && i > 1) {
            const double sign = now > last || now > next ? 1 : -1;
            double low = t_last, high = t_next;
            for (int k = 0; k < 60; ++k) {
                const double a = high - 0.6180339887498949 * (high - low);
                const double b = low + 0.6180339887498949 * (high - low);
                (sign * f(a) > sign * f(b) ? high : low) = sign * f(a) > sign * f(b) ? b : a;
            }
            const double t = 0.5 * (low + high), v = f(t);
            near_miss(v);
            if (side(v) != side(last)) {
                hit(t_last, t);
                return out;
            }
        }
        if (side(next) != side(now)) {
            hit(t_now, t_next);
            return out;
        }
        t_last = t_now, last = now;
        t_now = t_next, now = next;
    }
    near_miss(now);
    return out;
}

} // namespace ockham::reference

// SPDX-License-Identifier: Apache-2.0
#include "framework/scene/builtin_volume.hpp"

#include "framework/core/error.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numbers>
#include <vector>

namespace ockham {

namespace {

std::uint32_t hash(glm::ivec3 p, std::uint32_t seed) {
    std::uint32_t h = static_cast<std::uint32_t>(p.x) * 0x9e3779b1u ^
                      static_cast<std::uint32_t>(p.y) * 0x85ebca77u ^
                      static_cast<std::uint32_t>(p.z) * 0xc2b2ae3du ^ seed * 0x27d4eb2fu;
    h = (h ^ (h >> 15)) * 0x2c1b3c6du;
    h = (h ^ (h >> 12)) * 0x297a2d39u;
    return h ^ (h >> 15);
}

double smooth(double low, double high, double x) {
    const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

/// Gradient noise (Perlin 2002) in about [-1, 1], 0 at integer points.
double gradient_noise(glm::dvec3 p, std::uint32_t seed) {
    const glm::dvec3 base = glm::floor(p);
    const glm::dvec3 f = p - base;
    const glm::dvec3 fade = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    std::array<double, 8> corners;
    for (int i = 0; i < 8; ++i) {
        const glm::ivec3 step(i & 1, i >> 1 & 1, i >> 2);
        const glm::dvec3 d = f - glm::dvec3(step);
        // Toward one of the twelve edges of a cube.
        const std::uint32_t edge = hash(glm::ivec3(base) + step, seed) % 12;
        const double a = edge < 8 ? d.x : d.y;
        const double b = edge < 4 ? d.y : d.z;
        corners[i] = ((edge & 1) != 0 ? -a : a) + ((edge & 2) != 0 ? -b : b);
    }
    for (int i = 0; i < 4; ++i) corners[i] = glm::mix(corners[2 * i], corners[2 * i + 1], fade.x);
    for (int i = 0; i < 2; ++i) corners[i] = glm::mix(corners[2 * i], corners[2 * i + 1], fade.y);
    return glm::mix(corners[0], corners[1], fade.z);
}

/// Sum of octaves of |noise|, each of twice the frequency and half the amplitude: round billows
/// with creases between them (Ebert et al., Texturing and Modeling, "turbulence"). About [0, 1].
double billows(glm::dvec3 p, int octaves, std::uint32_t seed) {
    double sum = 0, amplitude = 1;
    for (int octave = 0; octave < octaves; ++octave, amplitude *= 0.5) {
        sum += amplitude * std::abs(gradient_noise(p, seed + static_cast<std::uint32_t>(octave)));
        p = p * 2.0 + glm::dvec3(0.31, 0.17, 0.53);
    }
    return sum;
}

struct Ball {
    glm::dvec3 center;
    double radius;
};

constexpr std::size_t kRoots = 9, kChildren = 7;

/// The bubbles that a cumulus is made of: a heap of nine, each with seven smaller ones on its upper
/// side, and these again. The children of ball i begin at kRoots + kChildren * i. In units of the
/// box's longest side, z from 0 at the bottom.
std::vector<Ball> cloud_balls() {
    std::vector<Ball> balls{{{0.50, 0.50, 0.26}, 0.220}, {{0.30, 0.45, 0.19}, 0.157},
        {{0.71, 0.55, 0.20}, 0.168}, {{0.50, 0.28, 0.17}, 0.145}, {{0.48, 0.72, 0.16}, 0.145},
        {{0.58, 0.52, 0.42}, 0.151}, {{0.41, 0.50, 0.37}, 0.122}, {{0.17, 0.50, 0.13}, 0.087},
        {{0.84, 0.47, 0.13}, 0.093}};
    constexpr std::size_t kParents = kRoots + kRoots * kChildren;
    for (std::size_t parent = 0; parent < kParents; ++parent)
        for (std::size_t child = 0; child < kChildren; ++child) {
            const Ball ball = balls[parent];
            const auto number = [&](int which) { // [0, 1)
                return (hash({int(parent), int(child), which}, 0) >> 8) * 0x1p-24;
            };
            glm::dvec3 way(number(0) - 0.5, number(1) - 0.5, number(2) - 0.25);
            way = way / std::sqrt(glm::dot(way, way) + 1e-6);
            balls.push_back({ball.center + way * (0.85 * ball.radius),
                ball.radius * (0.35 + 0.25 * number(3))});
        }
    return balls;
}

/// Raises `depth` to that below the surface of ball i and those that descend from it; these reach
/// no farther than 0.85 + 0.6 * (0.85 + 0.6) = 1.72 of its radius.
void deepen(const std::vector<Ball>& balls, std::size_t i, glm::dvec3 p, double& depth) {
    const glm::dvec3 d = p - balls[i].center;
    const double reach = 1.72 * balls[i].radius - depth;
    if (glm::dot(d, d) > reach * reach) return;
    depth = std::max(depth, balls[i].radius - std::sqrt(glm::dot(d, d)));
    const std::size_t first = kRoots + kChildren * i;
    if (first >= balls.size()) return;
    for (std::size_t child = 0; child < kChildren; ++child) deepen(balls, first + child, p, depth);
}

/// 0 to 1 at a point of the cloud's box.
double cloud_density(const std::vector<Ball>& balls, glm::dvec3 p) {
    constexpr double kBase = 0.07;   // height of the flat underside
    constexpr double kRelief = 0.05; // how far billows move the surface
    double depth = -kRelief;
    for (std::size_t root = 0; root < kRoots; ++root) deepen(balls, root, p, depth);
    const double base = p.z - kBase + 0.015 * gradient_noise(p * 11.0, 20);
    if (depth <= -kRelief || base <= 0) return 0;
    const double puff = billows(p * 10.0, 5, 1);
    const double inside = std::min(depth + kRelief * (2.3 * puff - 0.5), 0.6 * base);
    if (inside <= 0) return 0;
    // Wisps: finer noise eats the rim away, the more so the thinner it is.
    const double rim = smooth(0.0, 0.045, inside);
    const double eaten = 0.85 * billows(p * 37.0, 3, 40) * (1.0 - rim);
    const double core = 0.75 + 0.25 * gradient_noise(p * 6.0, 60);
    return std::clamp((rim - eaten) / (1.0 - eaten), 0.0, 1.0) * core;
}

template <class ValueAt>
void fill_bytes(Volume& volume, ValueAt&& value_at) {
    volume.type = VoxelType::uint8;
    volume.voxels.reserve(volume.voxel_count());
    for (std::uint32_t z = 0; z < volume.dims.z; ++z)
        for (std::uint32_t y = 0; y < volume.dims.y; ++y)
            for (std::uint32_t x = 0; x < volume.dims.x; ++x) {
                const double value = value_at(glm::dvec3(x, y, z) + 0.5);
                volume.voxels.push_back(static_cast<std::byte>(value * 255.0 + 0.5));
            }
}

Volume cloud(std::uint32_t side) {
    Volume volume;
    volume.dims = {side, side, std::max(1u, side * 3 / 4)};
    const std::vector<Ball> balls = cloud_balls();
    fill_bytes(volume, [&](glm::dvec3 p) { return cloud_density(balls, p / double(side)); });
    return volume;
}

Volume shells(std::uint32_t side) {
    constexpr double kGap = 3, kMargin = 2; // voxels
    Volume volume;
    volume.dims = glm::uvec3(side);
    const double half = 0.5 * side;
    fill_bytes(volume, [&](glm::dvec3 p) {
        const glm::dvec3 d = p - half;
        const double distance = std::sqrt(glm::dot(d, d));
        double outer = half - kMargin;
        for (int thickness = 1; thickness <= 8; ++thickness) {
            const double inner = outer - thickness;
            if (inner < 1) break;
            const double inside = std::min(distance - inner, outer - distance);
            if (inside > -0.5) return std::min(inside + 0.5, 1.0);
            outer = inner - kGap;
        }
        return 0.0;
    });
    return volume;
}

/// Raises voxels (uint8) to `value` in a ball, its rim a voxel wide. Voxel coordinates; centres lie
/// at + 1/2.
void put_ball(Volume& volume, glm::dvec3 center, double radius, double value) {
    const glm::ivec3 last = glm::ivec3(volume.dims) - 1;
    const glm::ivec3 from = glm::clamp(glm::ivec3(center - radius - 1.0), glm::ivec3(0), last);
    const glm::ivec3 to = glm::clamp(glm::ivec3(center + radius + 1.0), glm::ivec3(0), last);
    for (int z = from.z; z <= to.z; ++z)
        for (int y = from.y; y <= to.y; ++y)
            for (int x = from.x; x <= to.x; ++x) {
                const glm::dvec3 d = glm::dvec3(x, y, z) + 0.5 - center;
                const double inside = radius + 0.5 - std::sqrt(glm::dot(d, d));
                const double found = 255.0 * value * std::clamp(inside, 0.0, 1.0) + 0.5;
                std::byte& voxel =
                    volume.voxels[(std::size_t(z) * volume.dims.y + y) * volume.dims.x + x];
                voxel = std::max(voxel, static_cast<std::byte>(found));
            }
}

/// A cushion, soft at its rim, in air that is not quite empty.
double tissue_density(glm::dvec3 p) {
    const glm::dvec3 d = (p - glm::dvec3(0.5, 0.8, 0.5)) / glm::dvec3(0.46, 0.33, 0.46);
    const double depth = 1.0 - std::sqrt(glm::dot(d, d));
    const double fibre = 0.5 + 0.08 * gradient_noise(p * glm::dvec3(9.0, 9.0, 4.0), 80);
    return std::max(0.012, fibre * smooth(0.0, 0.08, depth));
}

Volume fingers(std::uint32_t side) {
    Volume volume;
    volume.dims = glm::uvec3(side);
    fill_bytes(volume, [&](glm::dvec3 p) { return tissue_density(p / double(side)); });
    const int steps = 4 * int(side); // closer than a voxel along each rod
    for (int finger = -2; finger <= 2; ++finger) {
        const double spread = finger, shorter = 0.05 * finger * finger;
        // A parabola from the knuckle over the bent joint to the tip.
        const glm::dvec3 knuckle(0.5 + 0.07 * spread, 0.42, 0.14);
        const glm::dvec3 joint(0.5 + 0.13 * spread, 0.26, 0.55 - 0.5 * shorter);
        const glm::dvec3 tip(0.5 + 0.17 * spread, 0.42, 0.88 - shorter);
        for (int step = 0; step <= steps; ++step) {
            const double t = double(step) / steps;
            const glm::dvec3 p = glm::mix(glm::mix(knuckle, joint, t), glm::mix(joint, tip, t), t);
            put_ball(volume, p * double(side), 1.9 - 0.9 * t, 1.0);
        }
    }
    return volume;
}

Volume cluster(std::uint32_t side) {
    Volume volume;
    volume.dims = glm::uvec3(side);
    // How much there is, by the squared distance from the middle: 1 to 1/37.
    const auto crowd = [](glm::dvec3 p) {
        const glm::dvec3 d = p - 0.5;
        const double wide = 1.0 + 20.0 * glm::dot(d, d);
        return 1.0 / (wide * wide);
    };
    fill_bytes(volume, [&](glm::dvec3 p) {
        const glm::dvec3 place = p / double(side);
        return 0.04 * crowd(place) * smooth(0.15, 0.6, billows(place * 7.0, 4, 100));
    });
    constexpr int kBlobs = 4000, kTries = 16;
    for (int blob = 0; blob < kBlobs; ++blob) {
        const auto number = [&](int which) { // [0, 1)
            return (hash({blob, which, 7}, 0) >> 8) * 0x1p-24;
        };
        // Rejection; the last try holds as it is, so that the number of blobs is sure.
        glm::dvec3 p(0.5);
        for (int attempt = 0; attempt < kTries; ++attempt) {
            p = {number(4 * attempt), number(4 * attempt + 1), number(4 * attempt + 2)};
            if (number(4 * attempt + 3) < crowd(p)) break;
        }
        const double radius = 0.4 + 0.9 * number(64) * number(65); // most are small
        put_ball(volume, p * double(side), radius, 0.5 + 0.5 * number(66));
    }
    return volume;
}

Volume of_ones(glm::uvec3 dims) {
    Volume volume;
    volume.dims = dims;
    volume.type = VoxelType::float32;
    volume.voxels.resize(volume.voxel_count() * sizeof(float));
    const float one = 1;
    for (std::size_t i = 0; i < volume.voxel_count(); ++i)
        std::memcpy(&volume.voxels[i * sizeof one], &one, sizeof one);
    return volume;
}

Volume slab(std::uint32_t side) {
    Volume volume = of_ones({side, side, std::max(1u, side / 64)});
    volume.spacing_mm.z = side / 64.0 / volume.dims.z;
    return volume;
}

} // namespace

Volume builtin_volume(const std::string& name, std::uint32_t side) {
    if (side < 1 || side > 1024)
        fail_input("volume '{}': {} voxels a side, expected 1 to 1024", name, side);
    Volume volume;
    if (name == "builtin:cloud")
        volume = cloud(side);
    else if (name == "builtin:fingers")
        volume = fingers(side);
    else if (name == "builtin:cluster")
        volume = cluster(side);
    else if (name == "builtin:shells")
        volume = shells(side);
    else if (name == "builtin:slab")
        volume = slab(side);
    else if (name == "builtin:constant")
        volume = of_ones(glm::uvec3(side));
    else
        fail_input("no volume '{}': there are builtin:cloud, builtin:fingers, builtin:cluster, "
                   "builtin:shells, builtin:slab, builtin:constant",
            name);
    volume.name = name;
    return volume;
}

Image sky_with_sun() {
    constexpr int kWidth = 128, kHeight = 64;
    constexpr double kPi = std::numbers::pi;
    const glm::dvec3 sun = glm::normalize(glm::dvec3(-0.5, -0.7, 0.6));
    Image image(kWidth, kHeight, {"R", "G", "B"});
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            const double theta = kPi * (y + 0.5) / kHeight, phi = 2 * kPi * (x + 0.5) / kWidth;
            const glm::dvec3 d(
                std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi));
            const bool in_sun = glm::dot(d, sun) > std::cos(5.0 * kPi / 180);
            const glm::dvec3 color =
                in_sun ? glm::dvec3(130.0)
                       : glm::mix(glm::dvec3(0.2), glm::dvec3(0.4, 0.5, 0.7), 0.5 + 0.5 * d.z);
            for (int c = 0; c < 3; ++c) image.at(x, y, c) = static_cast<float>(color[c]);
        }
    return image;
}

} // namespace ockham

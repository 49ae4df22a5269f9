// SPDX-License-Identifier: Apache-2.0
// Packed G-buffers in code, window by window, for tests of passes that look at surfaces: an
// orthographic or perspective picture whose samples are set one by one. Not a scene.
#pragma once

#include "framework/core/image.hpp"
#include "framework/core/rng.hpp"
#include "passes/surface/gbuffer.hpp"
#include "shaders/shared/frame.h"
#include "tests/reference/packing.hpp"
#include "tests/support/pass_bench.hpp"

#include <glm/gtc/packing.hpp>

#include <bit>
#include <limits>
#include <numeric>

namespace ockham::test {

/// Perspective with a near plane at 1: stored depth is 1 / view depth; 0 is background.
struct SurfaceWindows {
    static constexpr float kOdd[] = {std::numeric_limits<float>::quiet_NaN(),
        std::numeric_limits<float>::infinity(), 1e-40f, -1.0f, 0.0f, 3e38f};
    std::uint32_t width, height, m;
    std::vector<glm::uvec4> surface;
    std::vector<float> stored;
    std::vector<std::uint32_t> slopes; ///< of stored depth per sample, relative to it: 2 x fp16
    std::vector<glm::vec4> first_sample;
    std::vector<std::uint32_t> order;

    SurfaceWindows(std::uint32_t w, std::uint32_t h, std::uint32_t window)
        : width(w), height(h), m(window), surface(std::size_t{w} * h * m * m),
          stored(surface.size(), 0.0f), slopes(surface.size(), 0u),
          first_sample(std::size_t{w} * h, glm::vec4(0.0f)), order(m * m) {
        std::iota(order.begin(), order.end(), 0u);
    }

    std::uint32_t n() const { return m * m; }
    std::size_t pixels() const { return std::size_t{width} * height; }
    std::size_t place(std::uint32_t x, std::uint32_t y, std::uint32_t i) const {
        return std::size_t{y * m + i / m} * width * m + x * m + i % m;
    }
    void set(std::uint32_t x, std::uint32_t y, std::uint32_t i, float depth,
        glm::vec3 normal = {0, 0, 1}, std::uint32_t material = 0, glm::vec2 slope = {0, 0}) {
        stored[place(x, y, i)] = 1.0f / depth;
        surface[place(x, y, i)] = reference::pack_surface(normal, material);
        slopes[place(x, y, i)] = glm::packHalf2x16(slope * depth);
    }
    /// The same for every sample of every pixel.
    void fill(float depth, glm::vec3 normal = {0, 0, 1}, std::uint32_t material = 0) {
        for (std::uint32_t y = 0; y < height; ++y)
            for (std::uint32_t x = 0; x < width; ++x)
                for (std::uint32_t i = 0; i < n(); ++i) set(x, y, i, depth, normal, material);
    }
    /// Any bits at all, odd depths among them.
    void fill_with_garbage(Pcg32& rng) {
        for (glm::uvec4& words : surface) words = {rng.next(), rng.next(), rng.next(), rng.next()};
        for (std::uint32_t& slope : slopes) slope = rng.next();
        for (float& depth : stored)
            depth = rng.below(2) ? kOdd[rng.below(6)] : std::bit_cast<float>(rng.next());
    }
    /// S of a pixel: grey that displays as `luma`.
    void set_luma(std::uint32_t x, std::uint32_t y, float luma) {
        first_sample[std::size_t{y} * width + x] = glm::vec4(glm::vec3(srgb_decode(luma)), 1.0f);
    }
    /// Pixels are 1/100 wide and high at view depth 1.
    shader::FrameData frame() const {
        shader::FrameData data{};
        data.near_distance = 1.0f;
        data.far_distance = 1e6f;
        data.right = {0.005f * static_cast<float>(width), 0, 0};
        data.up = {0, 0.005f * static_cast<float>(height), 0};
        data.forward = {0, 0, -1};
        data.m = m;
        data.size = data.picture = {width, height};
        std::copy(order.begin(), order.end(), data.order);
        return data;
    }
    Gbuffer gbuffer(PassBench& bench) const {
        const std::uint32_t w = width * m, h = height * m;
        Gbuffer out;
        out.surface = bench.image("gbuffer", VK_FORMAT_R32G32B32A32_UINT, w, h, surface);
        out.depth = bench.image("depth", VK_FORMAT_R32_SFLOAT, w, h, stored);
        out.slopes = bench.image("slopes", VK_FORMAT_R32_UINT, w, h, slopes);
        return out;
    }
};

} // namespace ockham::test

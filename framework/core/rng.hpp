// SPDX-License-Identifier: Apache-2.0
// PCG32 (O'Neill 2014): a small seeded generator for scenes and tests. Not for rendering kernels,
// which key theirs by pixel and sample.
#pragma once

#include <cstdint>

namespace ockham {

/// Equal seeds give equal streams on every platform: all arithmetic is on integers.
class Pcg32 {
public:
    explicit Pcg32(std::uint64_t seed, std::uint64_t stream = 1) : increment_(2 * stream + 1) {
        next();
        state_ += seed;
        next();
    }
    /// Uniform over all 32-bit values.
    std::uint32_t next() {
        const std::uint64_t old = state_;
        state_ = old * 6364136223846793005ull + increment_;
        const auto shifted = static_cast<std::uint32_t>(((old >> 18) ^ old) >> 27);
        const auto rotate = static_cast<std::uint32_t>(old >> 59);
        return (shifted >> rotate) | (shifted << ((32 - rotate) & 31));
    }
    /// Uniform over [0, 1), multiples of 2^-24.
    float uniform() { return static_cast<float>(next() >> 8) * 0x1p-24f; }
    /// Uniform over [low, high).
    float uniform(float low, float high) { return low + (high - low) * uniform(); }
    /// Uniform over 0 ... count-1; count >= 1. Biased by less than count / 2^32.
    std::uint32_t below(std::uint32_t count) {
        return static_cast<std::uint32_t>((std::uint64_t{next()} * count) >> 32);
    }

private:
    std::uint64_t state_ = 0;
    std::uint64_t increment_;
};

} // namespace ockham

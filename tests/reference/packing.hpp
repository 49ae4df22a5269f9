// SPDX-License-Identifier: Apache-2.0
// Plain C++ twin of shaders/surface/packing.glsl: the G-buffer's 16 bytes a sample.
#pragma once

#include <glm/glm.hpp>
#include <glm/gtc/packing.hpp>

#include <cmath>
#include <cstdint>

namespace ockham::reference {

inline glm::vec2 octahedral_fold(glm::vec2 v) {
    return {(1.0f - std::abs(v.y)) * (v.x >= 0.0f ? 1.0f : -1.0f),
        (1.0f - std::abs(v.x)) * (v.y >= 0.0f ? 1.0f : -1.0f)};
}

/// Octahedral normal in two signed 16-bit numbers.
inline std::uint32_t pack_normal(glm::vec3 n) {
    const glm::vec2 p = glm::vec2(n) / (std::abs(n.x) + std::abs(n.y) + std::abs(n.z));
    return glm::packSnorm2x16(n.z >= 0.0f ? p : octahedral_fold(p));
}

inline glm::vec3 unpack_normal(std::uint32_t word) {
    const glm::vec2 p = glm::unpackSnorm2x16(word);
    glm::vec3 n(p, 1.0f - std::abs(p.x) - std::abs(p.y));
    if (n.z < 0.0f) {
        const glm::vec2 folded = octahedral_fold(p);
        n.x = folded.x;
        n.y = folded.y;
    }
    return glm::normalize(n);
}

/// A surface sample without texture coordinates.
inline glm::uvec4 pack_surface(glm::vec3 normal, std::uint32_t material) {
    return {pack_normal(normal), 0u, material << 20, (material >> 12) << 20};
}

inline std::uint32_t unpack_material(glm::uvec4 words) {
    return words.z >> 20 | (words.w >> 20) << 12;
}

/// One texture coordinate in [0,1) of words z or w.
inline float unpack_uv(std::uint32_t word) {
    return (static_cast<float>(word & 0xfffffu) + 0.5f) / 1048576.0f;
}

/// One of the four derivatives of word y, lowest byte first.
inline float unpack_derivative(std::uint32_t word, int index) {
    const std::uint32_t code = (word >> (8 * index)) & 255u;
    if ((code & 127u) == 0) return 0.0f;
    const float d = std::exp2((static_cast<float>(code & 127u) - 105.0f) * 0.25f);
    return code & 128u ? -d : d;
}

} // namespace ockham::reference

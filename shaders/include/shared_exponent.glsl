// SPDX-License-Identifier: Apache-2.0
// Three positive numbers in a word, as EXT_texture_shared_exponent has them.
#ifndef OCKHAM_SHARED_EXPONENT_GLSL
#define OCKHAM_SHARED_EXPONENT_GLSL

/// Three mantissas of 9 bits, an exponent of 5.
vec3 unpack_rgb9e5(uint word) {
    float scale = uintBitsToFloat((word >> 27u) + 127u - 24u << 23u);
    return vec3(word & 511u, word >> 9u & 511u, word >> 18u & 511u) * scale;
}

#endif

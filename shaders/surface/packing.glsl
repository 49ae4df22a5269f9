// SPDX-License-Identifier: Apache-2.0
// The packed G-buffer: 16 bytes a sample beside its depth, laid out as in Hollaender et al. 2013,
// figure 4 (normal, texture layer, coordinates and their derivatives; no albedo).
//   x  octahedral normal, 2 x 16 bits
//   y  derivatives of uv per sample: du/dx, dv/dx, du/dy, dv/dy, 8 bits each
//   z  u, 20 bits | low 12 bits of the material
//   w  v, 20 bits | high 12 bits of the material
// A second target of the same layout holds what few scenes have: x the vertex colour, y-w the
// second pair of coordinates.

#include "include/octahedral.glsl"
#include "surface/gbuffer.h"
#include "surface/material.glsl"

/// Sign and magnitude on a scale of four steps an octave, 2^-26 to 2^5.5; smaller is zero.
uint encode_derivative(float d) {
    float code = round(4.0 * log2(max(abs(d), 1e-30))) + 105.0;
    return code < 1.0 ? 0u : uint(min(code, 127.0)) | (d < 0.0 ? 128u : 0u);
}

float decode_derivative(uint code) {
    uint magnitude = code & 127u;
    if (magnitude == 0u) return 0.0;
    float d = exp2((float(magnitude) - 105.0) * 0.25);
    return (code & 128u) != 0u ? -d : d;
}

uvec3 pack_coordinates(TextureCoordinates c) {
    uint derivatives = encode_derivative(c.gradient_x.x) | encode_derivative(c.gradient_x.y) << 8 |
                       encode_derivative(c.gradient_y.x) << 16 | encode_derivative(c.gradient_y.y) << 24;
    uvec2 uv = uvec2(fract(c.uv) * 1048576.0) & 0xfffffu;
    return uvec3(derivatives, uv);
}

TextureCoordinates unpack_coordinates(uvec3 packed_words) {
    TextureCoordinates c;
    c.uv = (vec2(packed_words.yz & 0xfffffu) + 0.5) / 1048576.0;
    uint d = packed_words.x;
    c.gradient_x = vec2(decode_derivative(d & 255u), decode_derivative((d >> 8) & 255u));
    c.gradient_y = vec2(decode_derivative((d >> 16) & 255u), decode_derivative(d >> 24));
    return c;
}

uint pack_normal(vec3 normal) { return packSnorm2x16(octahedral_encode(normal)); }
vec3 unpack_normal(uint word) { return octahedral_decode(unpackSnorm2x16(word)); }

uvec4 pack_surface(vec3 normal, uint material, TextureCoordinates c) {
    uvec3 words = pack_coordinates(c);
    return uvec4(pack_normal(normal), words.x, words.y | material << 20,
        words.z | (material >> 12) << 20);
}

uint unpack_material(uvec4 packed_words) {
    return packed_words.z >> 20 | (packed_words.w >> 20) << 12;
}

/// It shows an isosurface, not a mesh.
bool is_iso_material(uint material) { return material >= ISO_MATERIAL; }

/// Linear colour factors above 1 are clamped.
uint pack_color(vec3 color) {
    uvec3 c = uvec3(sqrt(clamp(color, 0.0, 1.0)) * vec3(2047.0, 2047.0, 1023.0) + 0.5);
    return c.x | c.y << 11 | c.z << 22;
}

vec3 unpack_color(uint word) {
    vec3 c = vec3(word & 2047u, (word >> 11) & 2047u, word >> 22) / vec3(2047.0, 2047.0, 1023.0);
    return c * c;
}

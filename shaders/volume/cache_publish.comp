// SPDX-License-Identifier: Apache-2.0
// reads cache_sums; writes the means of cells with enough paths into cache_cells, in the format that
// readers see. The sums stay exact: formats round once, to nearest, and nothing drifts. In later
// rounds a mean replaces that of the round before once it is at least as good.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "volume/medium.glsl"
#include "volume/cache_error.glsl"

layout(local_size_x = 64) in;

layout(scalar, binding = 9) buffer CacheCells { uint words[]; } cache_cells;
layout(scalar, binding = 10) readonly buffer Control { CacheControl data; } cache_control;
layout(scalar, binding = 11) readonly buffer Sums { CacheSum items[]; } cache_sums;
layout(push_constant, scalar) uniform Push { CachePush push; };

/// EXT_texture_shared_exponent, section 3.8.x: the greatest channel chooses the exponent.
uint pack_rgb9e5(vec3 color) {
    vec3 c = clamp(color, vec3(0.0), vec3(65280.0)); // never all ones: CACHE_UNREFINED
    float greatest = max(max(c.x, c.y), c.z);
    int exponent = max(int(floatBitsToUint(greatest) >> 23u) - 127, -16) + 1; // floor(log2) + 1
    float unit = uintBitsToFloat(uint(exponent - 9 + 127) << 23u);
    if (round(greatest / unit) == 512.0) {
        ++exponent;
        unit *= 2.0;
    }
    uvec3 mantissas = uvec3(round(c / unit));
    return mantissas.x | mantissas.y << 9u | mantissas.z << 18u | uint(exponent + 15) << 27u;
}
uint pack_halves(vec2 v) { return packHalf2x16(clamp(v, vec2(-65504.0), vec2(65504.0))); }

void main() {
    uint slot = gl_GlobalInvocationID.y * gl_NumWorkGroups.x * 64u + gl_GlobalInvocationID.x;
    if (slot >= push.set) return;
    CacheSum sum = cache_sums.items[slot];
    if (sum.cell == CACHE_NONE || sum.count < sum.least) return;
    CacheControl control = cache_control.data;
    if (control.round > 0u && !cache_within(sum, 2.0 * control.goal)) return;

    uint words = push.format == CACHE_FP32 ? 3u : push.format == CACHE_FP16 ? 2u : 1u;
    uint at = (control.block * push.set + slot) * (words + 2u * push.directional);
    vec3 phi = sum.radiance / float(sum.count);
    if (push.format == CACHE_FP32) {
        for (int c = 0; c < 3; ++c) cache_cells.words[at + uint(c)] = floatBitsToUint(phi[c]);
    } else if (push.format == CACHE_FP16) {
        cache_cells.words[at] = pack_halves(phi.xy);
        cache_cells.words[at + 1u] = pack_halves(vec2(phi.z, 0.0));
    } else {
        cache_cells.words[at] = pack_rgb9e5(phi);
    }
    if (push.directional != 0u) {
        float luminance = cache_luminance(sum.radiance);
        vec3 flow = luminance > 0.0 ? sum.flow / luminance : vec3(0.0);
        cache_cells.words[at + words] = pack_halves(flow.xy);
        cache_cells.words[at + words + 1u] = pack_halves(vec2(flow.z, 0.0));
    }
}

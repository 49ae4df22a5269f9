// SPDX-License-Identifier: Apache-2.0
// Reads the cache: light that a point of the medium scatters, but for albedo and density.
//   reads cache_index, cache_cells
//   in-scatter(w) = int p(w, w') L(w') dw'  ~  phi + 3 g F.w      (harmonics up to order 1)
// with phi = mean radiance, F = mean of radiance times the direction that it comes from. Trilinear
// between cells; those without a value are left out, and near a surface those that the point does
// not see. Include after volume/medium.glsl.
#ifndef OCKHAM_VOLUME_CACHE_LOOKUP_GLSL
#define OCKHAM_VOLUME_CACHE_LOOKUP_GLSL

#include "volume/cache_geometry.glsl"

layout(scalar, binding = 8) readonly buffer CacheIndex { CacheHeader header; uint words[]; } cache_index;
layout(scalar, binding = 9) readonly buffer CacheCells { uint words[]; } cache_cells;

/// EXT_texture_shared_exponent: three mantissas of 9 bits, an exponent of 5.
vec3 unpack_rgb9e5(uint word) {
    float scale = uintBitsToFloat((word >> 27u) + 127u - 24u << 23u);
    return vec3(word & 511u, word >> 9u & 511u, word >> 18u & 511u) * scale;
}

/// The stored cell at a slot. False: it has no value yet. `flow`: F over the luminance of phi.
bool read_cache_cell(uint slot, out vec3 phi, out vec3 flow) {
    CacheHeader header = cache_index.header;
    uint at = slot * header.words;
    uint first = cache_cells.words[at];
    phi = vec3(0.0);
    flow = vec3(0.0);
    if (first == CACHE_UNREFINED) return false;
    if (header.format == CACHE_FP32) {
        phi = uintBitsToFloat(uvec3(first, cache_cells.words[at + 1u], cache_cells.words[at + 2u]));
    } else if (header.format == CACHE_FP16) {
        phi = vec3(unpackHalf2x16(first), unpackHalf2x16(cache_cells.words[at + 1u]).x);
    } else {
        phi = unpack_rgb9e5(first);
    }
    if (header.directional != 0u) {
        uint last = at + header.words - 1u;
        flow = vec3(unpackHalf2x16(cache_cells.words[last - 1u]), unpackHalf2x16(cache_cells.words[last]).x);
    }
    return true;
}

/// `unit`: a point of the medium; `direction`: unit, world, the way that the ray looks. Where no
/// cell around has a value or is seen, 0: dark rather than a leak. `budget` loses the iterations of
/// all loops; it stops at 0, and what has begun is finished.
vec3 cached_in_scatter(vec3 unit, vec3 direction, inout uint budget) {
    CacheHeader header = cache_index.header;
    vec3 place = unit * vec3(frame.data.dims) / float(header.scale) - 0.5;
    ivec3 base = ivec3(floor(place));
    vec3 fraction = place - vec3(base);
    vec3 phi_sum = vec3(0.0), flow_sum = vec3(0.0);
    float weight_sum = 0.0;
    for (int i = 0; i < 8; ++i) {
        ivec3 corner = ivec3(i & 1, i >> 1 & 1, i >> 2);
        ivec3 cell = base + corner;
        if (any(lessThan(cell, ivec3(0))) || any(greaterThanEqual(cell, ivec3(header.cells)))) continue;
        uvec3 c = uvec3(cell);
        uint word = cache_index.words[(c.z * header.cells.y + c.y) * header.cells.x + c.x];
        if (word == CACHE_NONE) continue;
        bool near = (word & CACHE_NEAR) != 0u;
        if (!near && word >> CACHE_PLACE_SHIFT == CACHE_PLACE_SOLID) continue;
        vec3 phi, flow;
        if (!read_cache_cell(word & CACHE_SLOT_MASK, phi, flow)) continue;
        if (near && header.occlusion != 0u &&
            !cache_sees(unit, cache_representative(c, header.scale, word), budget)) continue;
        vec3 weights = mix(1.0 - fraction, fraction, vec3(corner));
        float weight = weights.x * weights.y * weights.z;
        weight_sum += weight;
        phi_sum += weight * phi;
        flow_sum += weight * cache_luminance(phi) * flow;
    }
    budget -= min(budget, 9u);
    if (weight_sum <= 0.0) return vec3(0.0);
    vec3 phi = phi_sum / weight_sum;
    float luminance = cache_luminance(phi);
    if (header.directional == 0u || luminance <= 0.0) return phi;
    float share = 3.0 * frame.data.phase_g * dot(flow_sum / weight_sum, direction) / luminance;
    return phi * max(1.0 + share, 0.0); // order 1 may go below 0, light may not
}

#endif

// SPDX-License-Identifier: Apache-2.0
// Reads the cache: light that a point of the medium scatters, but for albedo and density.
//   reads cache_index, cache_cells
//   in-scatter(w) = int p(w, w') L(w') dw'  ~  phi + 3 g F.w      (harmonics up to order 1)
// with phi = mean radiance, F = mean of radiance times the direction that it comes from. Trilinear
// between cells; those without a value are left out, and near a surface those that the point does
// not see (SURFACES). Include after volume/medium.glsl.
#ifndef OCKHAM_VOLUME_CACHE_LOOKUP_GLSL
#define OCKHAM_VOLUME_CACHE_LOOKUP_GLSL

#include "include/shared_exponent.glsl"
#include "volume/cache_geometry.glsl"

layout(scalar, binding = 8) readonly buffer CacheIndex { CacheHeader header; uint words[]; } cache_index;
layout(scalar, binding = 9) readonly buffer CacheCells { uint words[]; } cache_cells;

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

/// Weighted sums over cells.
struct CacheBlend {
    vec3 phi;
    vec3 flow;
    float weight;
};
void blend_cell(inout CacheBlend blend, uint word, float weight) {
    vec3 phi, flow;
    if (!read_cache_cell(word & CACHE_SLOT_MASK, phi, flow)) return;
    blend.phi += weight * phi;
    blend.flow += weight * cache_luminance(phi) * flow;
    blend.weight += weight;
}

/// One of the eight cells around a place; `base`: the lowest. Its word; CACHE_NONE where it has no light.
uint corner_word(ivec3 base, ivec3 corner) {
    CacheHeader header = cache_index.header;
    ivec3 cell = base + corner;
    if (any(lessThan(cell, ivec3(0))) || any(greaterThanEqual(cell, ivec3(header.cells)))) return CACHE_NONE;
    uint word = cache_index.words[(uint(cell.z) * header.cells.y + uint(cell.y)) * header.cells.x + uint(cell.x)];
    return word >> CACHE_PLACE_SHIFT == CACHE_PLACE_SOLID ? CACHE_NONE : word;
}
ivec3 corner_of(uint i) { return ivec3(i & 1u, i >> 1u & 1u, i >> 2u); }
float corner_weight(vec3 fraction, ivec3 corner) {
    vec3 weights = mix(1.0 - fraction, fraction, vec3(corner));
    return weights.x * weights.y * weights.z;
}

/// `unit`: a point of the medium; `direction`: unit, world, the way that the ray looks. Where no
/// cell around has a value or is seen, 0: dark rather than a leak. `budget` loses the iterations of
/// all loops; it stops at 0, and what has begun is finished.
vec3 cached_in_scatter(vec3 unit, vec3 direction, inout uint budget) {
    CacheHeader header = cache_index.header;
    vec3 place = unit * vec3(frame.data.dims) / float(header.scale) - 0.5;
    ivec3 base = ivec3(floor(place));
    vec3 fraction = place - vec3(base);
    CacheBlend blend = CacheBlend(vec3(0.0), vec3(0.0), 0.0);
    uint unsure = 0u; // corners near a surface: a loop of their own, which most points do not enter
    for (uint i = 0u; i < 8u; ++i) {
        ivec3 corner = corner_of(i);
        uint word = corner_word(base, corner);
        if (word == CACHE_NONE) continue;
#ifdef SURFACES
        if (header.occlusion != 0u && (word & CACHE_NEAR) != 0u) {
            unsure |= 1u << i;
            continue;
        }
#endif
        blend_cell(blend, word, corner_weight(fraction, corner));
    }
    budget -= min(budget, 9u);
#ifdef SURFACES
    while (unsure != 0u) {
        ivec3 corner = corner_of(uint(findLSB(unsure)));
        unsure &= unsure - 1u;
        uint word = corner_word(base, corner);
        vec3 representative = cache_representative(uvec3(base + corner), header.scale, word);
        uint sight = cache_sees(unit, representative, budget);
        // Behind a translucent surface there is other light, but where nothing else is seen, better
        // that than none.
        float trust = sight == kSeen ? 1.0 : sight == kGlimpsed ? 1e-4 : 0.0;
        if (trust > 0.0) blend_cell(blend, word, trust * corner_weight(fraction, corner));
        budget -= min(budget, 1u);
    }
#endif
    if (blend.weight <= 0.0) return vec3(0.0);
    vec3 phi = blend.phi / blend.weight;
    float luminance = cache_luminance(phi);
    if (header.directional == 0u || luminance <= 0.0) return phi;
    float share = 3.0 * frame.data.phase_g * dot(blend.flow / blend.weight, direction) / luminance;
    return phi * max(1.0 + share, 0.0); // order 1 may go below 0, light may not
}

#endif

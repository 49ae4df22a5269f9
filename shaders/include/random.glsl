// SPDX-License-Identifier: Apache-2.0
// Random numbers keyed by (seed, stream, sample, set of dimensions), so that no two pixels, cells,
// samples or dimensions share one, and any can be had without those before it: hashes (pcg4d of
// Jarzynski and Olano 2020, a bijection).
// Where SPEC_SOBOL says so, the first kSobolSets sets of a stream are Owen-scrambled Sobol points
// over its samples: pairs xy and zw of a set are each a (0, 2)-sequence, shuffled by itself (Burley
// 2020, "Practical hash-based Owen scrambling"). No loops.
#ifndef OCKHAM_RANDOM_GLSL
#define OCKHAM_RANDOM_GLSL

#include "include/random.h"

layout(constant_id = SPEC_SOBOL) const bool kSobol = false;

struct Random {
    uint seed;
    uint stream; // pixel or cell
    uint index;  // sample of the stream
    uint set;    // next set of four dimensions
};

const uint kSobolSets = 64u; // beyond them paths are too long for stratification to last

Random make_random(uint seed, uint stream, uint index) { return Random(seed, stream, index, 0u); }

uvec4 hash4(uvec4 v) {
    v = v * 1664525u + 1013904223u;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    v ^= v >> 16u;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    return v;
}

/// To (0, 1): neither end is ever met, so logarithms are finite.
vec4 open_unit(uvec4 bits) { return (vec4(bits >> 9u) + 0.5) * 1.1920929e-7; }

/// A permutation that changes each bit by those below it only: on reversed bits, an Owen scrambling
/// (Laine and Karras 2011, with the constants of Vegdahl 2021).
uint scramble(uint reversed, uint seed) {
    reversed ^= reversed * 0x3d20adeau;
    reversed += seed;
    reversed *= (seed >> 16u) | 1u;
    reversed ^= reversed * 0x05526c56u;
    reversed ^= reversed * 0x53a22864u;
    return reversed;
}

/// Two dimensions of Sobol's sequence, each scrambled by a seed. The samples' order is scrambled,
/// too; reversed, it is the first dimension. The second follows by Pascal's triangle modulo 2.
uvec2 sobol2(uint reversed_index, uint order, uvec2 seeds) {
    uint first = scramble(reversed_index, order);
    uint second = first;
    second ^= second << 16u;
    second ^= (second & 0x00ff00ffu) << 8u;
    second ^= (second & 0x0f0f0f0fu) << 4u;
    second ^= (second & 0x33333333u) << 2u;
    second ^= (second & 0x55555555u) << 1u;
    return bitfieldReverse(uvec2(scramble(bitfieldReverse(first), seeds.x),
        scramble(bitfieldReverse(second), seeds.y)));
}

/// Four numbers in (0, 1) that know nothing of those of other samples: for what has no fixed place in
/// the order of dimensions, and cheaper.
vec4 independent4(Random random) {
    return open_unit(hash4(uvec4(random.seed, random.stream, random.index, random.set)));
}

/// Four numbers in (0, 1).
vec4 next4(inout Random random) {
    uint set = random.set++;
    // One hash serves both: of the stream as a seed of its points, of the sample beyond them.
    bool points = kSobol && set < kSobolSets;
    uvec4 bits = hash4(uvec4(random.seed, random.stream, points ? ~0u : random.index, set));
    if (points) {
        uvec4 orders = hash4(bits);
        uint index = bitfieldReverse(random.index);
        bits = uvec4(sobol2(index, orders.x, bits.xy), sobol2(index, orders.y, bits.zw));
    }
    return open_unit(bits);
}

#endif

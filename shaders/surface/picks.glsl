// SPDX-License-Identifier: Apache-2.0
// picks: which k of a pixel's n samples are shaded, one after another, and what each one weighs.
// Used by all that shade several samples; needs `frame` and Pick (shade_sample.glsl).
//   prefix      the first k of the order, each of weight 1 (Hollaender et al. 2013, section 3.2)
//   STRATIFIED  the picks are shared out among the window's surfaces (clusters.glsl) as seats are
//               among parties, by d'Hondt; of each surface the first in the order. A pick stands
//               for the samples of its surface, divided by its picks.
// Both agree bit for bit where a window sees one surface. At k = n: all samples, row-major, weight
// 1. The first pick of 1 < k < n is the first of the order.

#ifdef STRATIFIED
#include "surface/clusters.glsl"
#include "surface/surface_means.glsl"
layout(binding = 15) uniform usampler2D clusters;
#endif

struct Picks {
    uint k;
    uint rank; // where the next pick is looked for
    bool all;  // k = n
#ifdef STRATIFIED
    uvec4 labels; // of all samples, by rank
    uint sizes;   // samples of each surface; this and the next two: 8 bits a label
    uint seats;   // picks of each surface
    uint left;    // those still to come
    uint seen;    // samples of surfaces with picks
    uvec4 means;  // surface_means
#endif
};

#ifdef STRATIFIED
uint pack_bytes(uvec4 v) { return v.x | v.y << 8 | v.z << 16 | v.w << 24; }
uint byte_of(uint bytes, uint label) { return bitfieldExtract(bytes, int(8u * label), 8); }

/// Number of picks on each surface of a window of n samples. The first sample's surface has the
/// first, for it is shaded already; then all others one each, the largest first.
uvec4 share_picks(uvec4 sizes, uint k, uint n) {
    bool single = sizes.x == n;
    uvec4 seats = uvec4(single ? k : 1u, 0u, 0u, 0u);
    for (uint i = 1u, last = single ? 1u : k; i < last; ++i) {
        uvec4 claim = sizes * mix(uvec4(1u), uvec4(256u), equal(seats, uvec4(0u)));
        uvec4 divisor = seats + 1u;
        uvec3 best = uvec3(claim.x, divisor.x, 0u);
        if (claim.y * best.y > best.x * divisor.y) best = uvec3(claim.y, divisor.y, 1u);
        if (claim.z * best.y > best.x * divisor.z) best = uvec3(claim.z, divisor.z, 2u);
        if (claim.w * best.y > best.x * divisor.w) best = uvec3(claim.w, divisor.w, 3u);
        seats += uvec4(equal(uvec4(0u, 1u, 2u, 3u), best.zzzz));
    }
    return seats;
}
#endif

/// `k`: 1 ... n.
Picks begin_picks(ivec2 pixel, uint k) {
    uint n = frame.data.m * frame.data.m;
    Picks picks;
    picks.k = k;
    picks.rank = 0u;
    picks.all = k >= n;
#ifdef STRATIFIED
    uvec4 words = texelFetch(clusters, pixel, 0);
    picks.means = texelFetch(surface_means, pixel, 0);
    picks.labels = n <= 16u ? uvec4(words.x, 0u, 0u, 0u) : words;
    uvec4 sizes = cluster_sizes(picks.labels, n);
    uvec4 seats = share_picks(sizes, k, n);
    picks.sizes = pack_bytes(sizes);
    picks.seats = picks.left = pack_bytes(seats);
    uvec4 seen = sizes * uvec4(greaterThan(seats, uvec4(0u)));
    picks.seen = seen.x + seen.y + seen.z + seen.w;
#endif
    return picks;
}

/// The next sample. Not to be called more than k times.
Pick next_pick(inout Picks picks) {
    uint n = frame.data.m * frame.data.m;
    uint rank = picks.rank;
    Pick pick = Pick(0u, 1.0, picks.all ? 1.0 : float(frame.data.m) * inversesqrt(float(picks.k)), 0.0, 0u);
#ifdef STRATIFIED
    uint label = cluster_label(picks.labels, rank);
    for (; !picks.all && rank + 1u < n && byte_of(picks.left, label) == 0u;) {
        label = cluster_label(picks.labels, ++rank);
    }
    uint size = byte_of(picks.sizes, label), seats = byte_of(picks.seats, label);
    if (!picks.all && size < n) {
        picks.left -= 1u << 8u * label;
        pick.weight = float(size * picks.k) / float(picks.seen * seats);
        pick.widening = sqrt(float(size) / float(seats));
    }
    if (!picks.all && seats < size) {
        pick.albedo = mean_albedo(picks.means, label);
        // A share of 1/k: what varies between the picks needs no widening. None at k = n.
        pick.roughening = roughening(picks.means, float(size - seats) / float(seats * (size - 1u)));
    }
#endif
    picks.rank = rank + 1u;
    pick.index = picks.all ? rank : frame.data.order[rank];
    return pick;
}

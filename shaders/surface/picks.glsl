// SPDX-License-Identifier: Apache-2.0
// picks: which k of a pixel's n samples are shaded, one after another, and what each one weighs.
// Used by all that shade several samples; needs `frame` (shared/frame.h).
//   prefix  the first k of the order, each of weight 1 (Hollaender et al. 2013, section 3.2)
// At k = n: all of them in row-major order. The first pick of 1 < k < n is the first of the order.

struct Picks {
    uint k;
    uint rank;      // of the next pick
    float widening; // how much wider than one sample, per axis, what a pick stands for is
};

/// `k`: 1 ... n.
Picks begin_picks(ivec2 pixel, uint k) {
    uint m = frame.data.m;
    return Picks(k, 0u, k >= m * m ? 1.0 : float(m) * inversesqrt(float(k)));
}

/// Index in the window, row-major, of the next sample. Not to be called more than k times.
/// `weight`: of its colour in the sum of k; all weights add up to k. `widening`: for shade_sample().
uint next_pick(inout Picks picks, out float weight, out float widening) {
    weight = 1.0;
    widening = picks.widening;
    uint rank = picks.rank++;
    return picks.k >= frame.data.m * frame.data.m ? rank : frame.data.order[rank];
}

// SPDX-License-Identifier: Apache-2.0
// The sum of one pixel's samples, of which one dispatch or draw adds the picks push.first ...
// push.last - 1. Shared by the back ends that shade several samples per pixel, so that they differ
// in who works when, not in what comes out. CONTINUE: the sums begin where an earlier round ended.
//   1 < k < n:  sum = weight S + sum of weight shade(pick)      the first pick is S's
//   k = n:      sum of all n, shaded anew: full supersampling
// UNIFORM has no S: all k are shaded.

#include "surface/shade_sample.glsl"
#include "surface/picks.glsl"

#ifndef UNIFORM
layout(binding = 13, rgba32f) uniform readonly image2D first_sample;
#endif
#ifdef CONTINUE
layout(binding = 14, rgba32f) uniform image2D shaded_sum;
#else
layout(binding = 14, rgba32f) uniform writeonly image2D shaded_sum;
#endif

/// True if this round has nothing to add to a pixel of k samples.
bool is_done(uint k) {
#ifdef UNIFORM
    return false;
#else
    return k <= max(push.first, 1u);
#endif
}

/// The sum so far. `picks`: of the pixel, just begun, moves on to the first that is missing, whose
/// number `next` is.
vec4 begin_sum(ivec2 pixel, uint k, inout Picks picks, out uint next) {
    next = push.first;
#ifdef CONTINUE
    for (uint i = 0u; i < next; ++i) next_pick(picks);
    return imageLoad(shaded_sum, pixel);
#else
#ifndef UNIFORM
    if (k < frame.data.m * frame.data.m) {
        Pick pick = next_pick(picks);
        next = 1u;
        return pick.weight * imageLoad(first_sample, pixel);
    }
#endif
    return vec4(0.0);
#endif
}

/// All of this round for one pixel.
void shade_pixel(ivec2 pixel, uint k) {
    if (is_done(k)) return;
    Picks picks = begin_picks(pixel, k);
    uint first;
    precise vec4 sum = begin_sum(pixel, k, picks, first);
    uint last = min(min(push.last, k), first + push.loop_bound);
    for (uint i = first; i < last; ++i) {
        Pick pick = next_pick(picks);
        sum += pick.weight * shade_sample(pixel, pick);
    }
    imageStore(shaded_sum, pixel, sum);
}

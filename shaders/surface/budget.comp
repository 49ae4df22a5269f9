// SPDX-License-Identifier: Apache-2.0
// reads variance, budget_price and the prefix sums of budget_runs; writes k: the samples of the
// price, and of those worth the next lower one as many as are left, in the order of the pixels.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "surface/budget.glsl"
#include "surface/metrics.h"

layout(local_size_x = 64) in;

layout(binding = 0, rg32f) uniform readonly image2D variance;
layout(scalar, binding = 2) readonly buffer BudgetPriceIn { BudgetPrice price; } budget_price;
layout(scalar, binding = 3) readonly buffer BudgetRuns { uint items[]; } budget_runs;
layout(binding = 4, r8ui) uniform writeonly uimage2D sample_count;
#ifdef WINNER
layout(binding = 5, r8ui) uniform writeonly uimage2D winner;
#endif
layout(push_constant, scalar) uniform Push { BudgetPush push; };

void main() {
    uint pixels = push.size.x * push.size.y, first = gl_GlobalInvocationID.x * push.run;
    if (first >= pixels) return;
    BudgetPrice price = budget_price.price;
    uint before = budget_runs.items[gl_GlobalInvocationID.x];
    for (uint i = first, last = min(first + push.run, pixels); i < last; ++i) {
        ivec2 pixel = ivec2(i % push.size.x, i / push.size.x);
        vec2 expected = imageLoad(variance, pixel).xy;
        uvec2 around = samples_around(expected, price, push.samples);
        uint k = around.x + min(around.y, price.left - min(before, price.left));
        before += around.y;
        imageStore(sample_count, pixel, uvec4(k));
#ifdef WINNER
        bool surfaces = expected.y > 0.0 && k <= surface_count(expected);
        imageStore(winner, pixel, uvec4(k <= 1u ? WINNER_NONE : surfaces ? WINNER_SURFACES : WINNER_VARIATION));
#endif
    }
}

// SPDX-License-Identifier: Apache-2.0
// reads variance and budget_price; writes budget_runs: for each run of pixels, samples that the
// next lower price would add.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "surface/budget.glsl"

layout(local_size_x = 64) in;

layout(binding = 0, rg32f) uniform readonly image2D variance;
layout(scalar, binding = 2) readonly buffer BudgetPriceIn { BudgetPrice price; } budget_price;
layout(scalar, binding = 3) writeonly buffer BudgetRuns { uint items[]; } budget_runs;
layout(push_constant, scalar) uniform Push { BudgetPush push; };

void main() {
    uint pixels = push.size.x * push.size.y, first = gl_GlobalInvocationID.x * push.run;
    if (first >= pixels) return;
    BudgetPrice price = budget_price.price;
    uint sum = 0u;
    for (uint i = first, last = min(first + push.run, pixels); i < last; ++i) {
        vec2 expected = imageLoad(variance, ivec2(i % push.size.x, i / push.size.x)).xy;
        sum += samples_around(expected, price, push.samples).y;
    }
    budget_runs.items[gl_GlobalInvocationID.x] = sum;
}

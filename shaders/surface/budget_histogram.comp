// SPDX-License-Identifier: Apache-2.0
// reads variance; adds each pixel to budget_bins, which must begin as zeros. Sums of integers do
// not depend on their order.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "surface/budget.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0, rg32f) uniform readonly image2D variance;
layout(scalar, binding = 1) buffer BudgetBins { BudgetBin items[]; } budget_bins;
layout(push_constant, scalar) uniform Push { BudgetPush push; };

/// The largest bin with law_threshold(k) * value <= within, exactly.
int law_bin(float within, uint k) {
    int bin = int(floatBitsToUint(within / law_threshold(k)) >> 19) - int(kFirstBin);
    if (bin + 1 < BUDGET_BINS && law_threshold(k) * bin_value(uint(bin + 1)) <= within) ++bin;
    if (law_threshold(k) * bin_value(uint(bin)) > within) --bin;
    return bin;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(push.size)))) return;
    vec2 expected = imageLoad(variance, pixel).xy;
    if (expected.x > 0.0) atomicAdd(budget_bins.items[value_bin(expected.x)].within, 1u);
    // Where surfaces ask for more than the law: from their own price down to the law's.
    uint surfaces = expected.y > 0.0 ? min(surface_count(expected), push.samples) : 1u;
    for (uint k = 2u; k <= surfaces; ++k) {
        int own = int(value_bin(expected.y));
        int law = expected.x > 0.0 ? law_bin(bin_value(value_bin(expected.x)), k) : -1;
        if (own > law) {
            atomicAdd(budget_bins.items[own].surfaces, 1);
            if (law >= 0) atomicAdd(budget_bins.items[law].surfaces, -1);
        }
    }
}

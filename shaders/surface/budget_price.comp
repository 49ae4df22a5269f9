// SPDX-License-Identifier: Apache-2.0
// reads budget_bins; writes budget_price: the lowest price whose samples are within the target, and
// what is then left. One workgroup; each invocation has a run of bins.
//   samples(bin) = pixels + sum over k = 2 ... n of pixels with w^2 >= k (k - 1) value(bin)
//                         + sum of `surfaces` from the bin upwards
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "surface/budget.glsl"

const uint kRun = BUDGET_BINS / BUDGET_SCAN_WIDTH;
layout(local_size_x = BUDGET_SCAN_WIDTH) in;

layout(scalar, binding = 1) readonly buffer BudgetBins { BudgetBin items[]; } budget_bins;
layout(scalar, binding = 2) writeonly buffer BudgetPriceOut { BudgetPrice price; } budget_price;
layout(push_constant, scalar) uniform Push { BudgetPush push; };

shared uint above[BUDGET_BINS + 1]; // pixels with w^2 of a bin or more
shared int extra[BUDGET_BINS];      // samples for surfaces at the price of a bin
shared ivec2 run_sum[BUDGET_SCAN_WIDTH];
shared uint lowest;

void main() {
    uint lane = gl_LocalInvocationIndex, first = lane * kRun;
    ivec2 sum = ivec2(0);
    for (uint i = 0u; i < kRun; ++i) {
        BudgetBin bin = budget_bins.items[first + i];
        sum += ivec2(int(bin.within), bin.surfaces);
    }
    run_sum[lane] = sum;
    if (lane == 0u) lowest = BUDGET_BINS - 1u;
    barrier();
    for (uint stride = 1u; stride < BUDGET_SCAN_WIDTH; stride *= 2u) {
        ivec2 beyond = lane + stride < BUDGET_SCAN_WIDTH ? run_sum[lane + stride] : ivec2(0);
        barrier();
        run_sum[lane] += beyond;
        barrier();
    }
    ivec2 from_here = run_sum[lane];
    for (uint i = 0u; i < kRun; ++i) {
        above[first + i] = uint(from_here.x);
        extra[first + i] = from_here.y;
        BudgetBin bin = budget_bins.items[first + i];
        from_here -= ivec2(int(bin.within), bin.surfaces);
    }
    if (lane == 0u) above[BUDGET_BINS] = 0u;
    barrier();

    uint pixels = push.size.x * push.size.y, best = BUDGET_BINS, spent = 0u;
    for (uint i = kRun; i-- > 0u;) {
        uint bin = first + i;
        uint samples = pixels + uint(extra[bin]);
        float lambda = bin_value(bin);
        for (uint k = 2u; k <= push.samples; ++k) samples += above[bin_reaching(law_threshold(k) * lambda)];
        if (samples <= push.target) {
            best = bin;
            spent = samples;
        }
    }
    atomicMin(lowest, best);
    barrier();
    if (best == lowest) budget_price.price = BudgetPrice(best, push.target - spent);
}

// SPDX-License-Identifier: Apache-2.0
// Variance in bins, so that a histogram tells for every price how many samples it buys. A bin holds
// the values that share their leading bits, sixteen bins an octave; all count as the least of them.
// Comparing bins times integers up to 64 * 63 is exact in fp32, so all kernels count alike.

#include "surface/budget.h"
#include "surface/variance.glsl"

const uint kFirstBin = 224u;          // leading bits of 2^-113
const float kLeastVariance = 7.9e-31; // 2^-100: what is less counts as this, prices go 4032 lower

float bin_value(uint bin) { return uintBitsToFloat(bin + kFirstBin << 19); }
/// Of x > 0.
uint value_bin(float x) {
    return min((floatBitsToUint(max(x, kLeastVariance)) >> 19) - kFirstBin, BUDGET_BINS - 1u);
}
/// The first bin whose value is x or more; BUDGET_BINS: none.
uint bin_reaching(float x) {
    return min((floatBitsToUint(x) + 0x7ffffu >> 19) - kFirstBin, uint(BUDGET_BINS));
}

/// Thresholds of the law: the k-th sample is taken where w^2 >= k (k - 1) lambda.
float law_threshold(uint k) { return float(k * (k - 1u)); }

/// allocated_samples() for the price of a bin.
uint samples_at(vec2 variance, uint bin, uint n) {
    float lambda = bin_value(bin);
    float within = variance.x > 0.0 ? bin_value(value_bin(variance.x)) : 0.0;
    uint k = uint(clamp(floor(0.5 + sqrt(0.25 + within / lambda)), 1.0, float(n)));
    // Division and root round; the thresholds do not.
    if (k > 1u && within < law_threshold(k) * lambda) --k;
    if (k < n && within >= law_threshold(k + 1u) * lambda) ++k;
    bool surfaces = variance.y > 0.0 && value_bin(variance.y) >= bin;
    return max(k, surfaces ? min(surface_count(variance), n) : 1u);
}

/// Samples of a pixel at the price, and how many more at the next lower one.
uvec2 samples_around(vec2 variance, BudgetPrice price, uint n) {
    uint k = samples_at(variance, price.bin, n);
    return uvec2(k, samples_at(variance, max(price.bin, 1u) - 1u, n) - k);
}

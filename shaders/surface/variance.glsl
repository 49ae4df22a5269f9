// SPDX-License-Identifier: Apache-2.0
// The image `variance` (rg32f) and the samples that follow from it:
//   x  w^2: variance of a pixel's colours within surfaces, >= 0
//   y  b^2 / (C - 1): what each sample from the second to the C-th removes of the variance between
//      the C surfaces of its window, > 0 if there are several; C - 1 stands in the two lowest bits
//      of its mantissa
//   k = max(k_w, y >= lambda ? C : 1),   k_w = floor(1/2 + sqrt(1/4 + w^2 / lambda)), in 1 ... n
// k_w is the integer that minimises w^2 / k + lambda k: Neyman's allocation.

vec2 pack_variance(float within, float between, uint surfaces) {
    // Never a denormal number, which some devices take for 0.
    uint bits = max(floatBitsToUint(between / float(max(surfaces, 2u) - 1u)) & ~3u, 0x800000u);
    return vec2(within, surfaces > 1u ? uintBitsToFloat(bits | surfaces - 1u) : 0.0);
}

uint surface_count(vec2 variance) { return (floatBitsToUint(variance.y) & 3u) + 1u; }

/// `lambda`: 0 asks for n, infinity for 1.
uint allocated_samples(vec2 variance, float lambda, uint n) {
    if (lambda <= 0.0) return n;
    float k = clamp(floor(0.5 + sqrt(0.25 + variance.x / lambda)), 1.0, float(n));
    return max(uint(k), variance.y >= lambda ? min(surface_count(variance), n) : 1u);
}

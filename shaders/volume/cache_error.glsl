// SPDX-License-Identifier: Apache-2.0
// How well the mean of a cell is known: the squared standard error of its luminance against what a
// relative error of 1 would be. Dark cells are held to a hundredth of the light's own radiance.
//   s^2 / n, s^2 = (sum x^2 - n mean^2) / (n - 1)
// Include after volume/medium.glsl.
#ifndef OCKHAM_VOLUME_CACHE_ERROR_GLSL
#define OCKHAM_VOLUME_CACHE_ERROR_GLSL

#include "volume/cache_geometry.glsl"

/// Its square is what squared errors are relative to.
float cache_scale_of_error(CacheSum sum) {
    const float inverse_sphere = 0.0795774715;
    float light = cache_luminance(frame.data.environment) + cache_luminance(frame.data.light_irradiance) * inverse_sphere;
    return max(cache_luminance(sum.radiance) / float(sum.count), 0.01 * light);
}
/// Squared standard error of the mean; 0 to 1 paths: infinite.
float cache_squared_error(CacheSum sum) {
    if (sum.count < 2u) return 1e30;
    float n = float(sum.count);
    float mean = cache_luminance(sum.radiance) / n;
    return max(sum.square - n * mean * mean, 0.0) / (n * (n - 1.0));
}
/// The mean's relative standard error is at most `goal`.
bool cache_within(CacheSum sum, float goal) {
    float bound = goal * cache_scale_of_error(sum);
    return cache_squared_error(sum) <= bound * bound;
}

#endif

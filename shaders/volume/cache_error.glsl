// SPDX-License-Identifier: Apache-2.0
// How well the mean of a cell is known: the squared standard error of its luminance against what a
// relative error of 1 would be. Dark cells are held to a twentieth of the light's own radiance L.
//   s^2 / n, s^2 = (sum x^2 - n mean^2 + L^2) / (n - 1)
// L^2 stands for a path that nobody has seen yet: n paths that all brought nothing do not prove that
// a cell is dark, they only say that its light is likely to be below L / n.
// Include after volume/medium.glsl.
#ifndef OCKHAM_VOLUME_CACHE_ERROR_GLSL
#define OCKHAM_VOLUME_CACHE_ERROR_GLSL

#include "volume/cache_geometry.glsl"

/// Luminance of the light itself, as a cell would see it with nothing in between.
float cache_light() {
    const float inverse_sphere = 0.0795774715;
    return cache_luminance(frame.data.environment) + frame.data.emission_most +
           cache_luminance(frame.data.light_irradiance) * inverse_sphere;
}
/// Its square is what squared errors are relative to.
float cache_scale_of_error(CacheSum sum) {
    return max(cache_luminance(sum.radiance) / float(sum.count), 0.05 * cache_light());
}
/// Squared standard error of the mean; 0 to 1 paths: infinite.
float cache_squared_error(CacheSum sum) {
    if (sum.count < 2u) return 1e30;
    float n = float(sum.count);
    float mean = cache_luminance(sum.radiance) / n;
    float unseen = cache_light();
    return (max(sum.square - n * mean * mean, 0.0) + unseen * unseen) / (n * (n - 1.0));
}
/// How many paths a mean needs for a relative standard error of `goal`, as those of the sum judge it.
float cache_need(CacheSum sum, float goal) {
    float bound = goal * cache_scale_of_error(sum), error = cache_squared_error(sum);
    return error > 0.0 ? float(sum.count) * error / (bound * bound) : 0.0;
}
/// The mean's relative standard error is at most `goal`.
bool cache_within(CacheSum sum, float goal) {
    float bound = goal * cache_scale_of_error(sum), error = cache_squared_error(sum);
    return error <= bound * bound && (error > 0.0 || cache_light() == 0.0);
}

#endif

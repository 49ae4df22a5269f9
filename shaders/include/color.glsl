// SPDX-License-Identifier: Apache-2.0
// Luminance, display encoding and luma. Everything else in the shaders is linear radiance.
#ifndef OCKHAM_COLOR_GLSL
#define OCKHAM_COLOR_GLSL

const vec3 kRec709 = vec3(0.2126, 0.7152, 0.0722);

/// Rec. 709 luminance of linear colour.
float luminance(vec3 linear) { return dot(linear, kRec709); }

/// sRGB transfer function (IEC 61966-2-1) of clamped linear colour.
vec3 srgb_encode(vec3 linear) {
    vec3 c = clamp(linear, 0.0, 1.0);
    return mix(1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, 12.92 * c, lessThanEqual(c, vec3(0.0031308)));
}

/// Its inverse; `encoded` in [0,1].
vec3 srgb_decode(vec3 encoded) {
    return mix(pow((encoded + 0.055) / 1.055, vec3(2.4)), encoded / 12.92, lessThanEqual(encoded, vec3(0.04045)));
}

/// Rec. 709 luma of display-encoded colour, in [0,1].
float luma(vec3 linear) { return dot(srgb_encode(linear), kRec709); }

#endif

// SPDX-License-Identifier: Apache-2.0
// Texture lookups over an anisotropic footprint given by its gradients, as textureGrad does, but
// split here into trilinear taps along the longer axis, so that every driver filters alike (some
// software drivers alias badly at high ratios). Layers of an array are padded to a common size:
// mip level l holds the image at 1/2^l of its *native* size, whatever the layer's size.
#ifndef OCKHAM_SHADERS_INCLUDE_FOOTPRINT_GLSL
#define OCKHAM_SHADERS_INCLUDE_FOOTPRINT_GLSL

/// `gradient_x`, `gradient_y`: change of uv across the footprint. `size`: native texels.
/// `max_taps`: at most so many taps (maximum anisotropy), >= 1. uv wraps around.
vec4 sample_footprint(sampler2DArray image, int layer, vec2 size, vec2 uv, vec2 gradient_x,
    vec2 gradient_y, float max_taps) {
    vec2 texels_x = gradient_x * size;
    vec2 texels_y = gradient_y * size;
    float length_x = length(texels_x);
    float length_y = length(texels_y);
    bool x_longer = length_x > length_y;
    float major = max(x_longer ? length_x : length_y, 1e-8);
    float minor = x_longer ? length_y : length_x;
    vec2 axis = x_longer ? gradient_x : gradient_y;
    float taps = clamp(ceil(min(major / max(minor, 1e-8), major) - 0.01), 1.0, max_taps);
    float level = max(log2(major / taps), 0.0);
    vec4 sum = vec4(0.0);
    for (float i = 0.0; i < taps; i += 1.0) {
        sum += textureLod(image, vec3(uv + axis * ((i + 0.5) / taps - 0.5), layer), level);
    }
    return sum / taps;
}

#endif

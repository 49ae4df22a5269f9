// SPDX-License-Identifier: Apache-2.0
// reads radiance and weights; writes each pixel blended with its neighbours along the axis on which
// it loses more. Linear radiance: weights are areas, and areas add up as light.
//   out = sum a_i (p (1 - a_i) + p_i a_i) / sum a_i      i: the two neighbours on the axis
// Jimenez et al., SMAA, Eurographics 2012, section 3.
#version 460

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0) uniform sampler2D radiance;
layout(binding = 1) uniform sampler2D weights;
layout(binding = 2, rgba32f) uniform writeonly image2D filtered;

/// At the border a weight towards outside is 0, so any pixel does.
vec4 at(ivec2 position) {
    return texelFetch(radiance, clamp(position, ivec2(0), textureSize(radiance, 0) - 1), 0);
}

/// What a pixel beyond says of this one; none does outside.
vec4 weights_at(ivec2 position) {
    return any(greaterThanEqual(position, textureSize(weights, 0))) ? vec4(0.0) : texelFetch(weights, position, 0);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, textureSize(radiance, 0)))) return;
    vec4 own = weights_at(pixel);
    vec2 vertical = vec2(own.x, weights_at(pixel + ivec2(0, 1)).y);
    vec2 horizontal = vec2(own.z, weights_at(pixel + ivec2(1, 0)).w);
    bool across_columns = max(horizontal.x, horizontal.y) > max(vertical.x, vertical.y);
    vec2 a = across_columns ? horizontal : vertical;
    ivec2 step_to = across_columns ? ivec2(1, 0) : ivec2(0, 1);

    vec4 center = at(pixel);
    vec4 blended = a.x * mix(center, at(pixel - step_to), a.x) + a.y * mix(center, at(pixel + step_to), a.y);
    float sum = a.x + a.y;
    imageStore(filtered, pixel, sum > 0.0 ? blended / sum : center);
}

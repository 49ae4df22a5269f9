// SPDX-License-Identifier: Apache-2.0
// reads variance of this frame and, where its surface was one frame ago, the steadied variance of
// then; writes the steadied variance of now, in the same form (variance.glsl).
//   v' = max(v, v + keep (h - v))        h: the steadied v of one frame ago
// The place is that of the first sample's surface, as that of Herzog et al. 2010, section 3
// (Spatio-Temporal Upsampling on the GPU).
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "shared/frame.h"
#include "surface/variance.glsl"
#include "surface/variance_history.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(scalar, binding = 0) uniform Frame { FrameData data; } frame;
layout(scalar, binding = 1) uniform FrameBefore { FrameData data; } frame_before;
layout(binding = 2, rg32f) uniform readonly image2D variance;
layout(binding = 3, rg32ui) uniform readonly uimage2D first_surface;
layout(binding = 4) uniform sampler2D history_before;
layout(binding = 5, rg32f) uniform writeonly image2D history;
layout(push_constant, scalar) uniform Push { VarianceHistoryPush push; };

/// Where the pixel's first sample was seen one frame ago, in pixels; a background is far away.
vec2 place_before(ivec2 pixel) {
    uint m = frame.data.m, first = frame.data.order[0];
    vec2 at = vec2(pixel) + (vec2(first % m, first / m) + 0.5) / float(m);
    vec2 ndc = at / vec2(frame.data.size) * vec2(2.0, -2.0) + vec2(-1.0, 1.0);
    vec3 across = ndc.x * frame.data.right + ndc.y * frame.data.up;
    bool orthographic = frame.data.orthographic != 0u;
    float stored = uintBitsToFloat(imageLoad(first_surface, pixel).x);
    float depth = orthographic ? frame.data.far_distance * (1.0 - stored) : frame.data.near_distance / stored;
    vec4 world = stored > 0.0
        ? vec4(frame.data.position + depth * frame.data.forward + (orthographic ? across : across * depth), 1.0)
        : vec4(frame.data.forward + across, 0.0);
    vec4 clip = frame_before.data.view_projection * world;
    if (orthographic && stored <= 0.0 || clip.w <= 0.0) return vec2(-1.0);
    return (0.5 * clip.xy / clip.w + 0.5) * vec2(frame.data.size);
}

float steadied(float now, float before) {
    return max(now, mix(now, before, push.keep));
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(frame.data.size)))) return;
    vec2 now = imageLoad(variance, pixel).xy;
    vec2 place = place_before(pixel);
    bool seen = all(greaterThanEqual(place, vec2(0.0))) && all(lessThan(place, vec2(frame.data.size)));
    ivec2 from = clamp(ivec2(place), ivec2(0), ivec2(frame.data.size) - 1);
    vec2 before = seen ? texelFetch(history_before, from, 0).xy : now;
    // What the window holds now stands in the two lowest bits; one surface has nothing between.
    uint surfaces = floatBitsToUint(now.y) & 3u;
    uint between = floatBitsToUint(steadied(now.y, before.y)) & ~3u;
    imageStore(history, pixel, vec4(steadied(now.x, before.x),
        surfaces > 0u ? uintBitsToFloat(between | surfaces) : 0.0, 0.0, 0.0));
}

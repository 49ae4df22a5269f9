// SPDX-License-Identifier: Apache-2.0
// reads this frame's jittered picture with its depth, and the history; writes the new history, which
// is the picture.
//   out = h + (c - h) / frames
// A camera that stands still: h is the history's own pixel, so that out is the plain mean of all
// frames. Moving: h is where the surface was, clamped to the colours of the 3 x 3 pixels here.
// Yang, Liu, Salvi, A Survey of Temporal Antialiasing Techniques, Eurographics 2020.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "post/taa.h"
#include "shared/frame.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(scalar, binding = 0) uniform Frame { FrameData data; } frame;
#include "surface/surface_sample.glsl"
layout(binding = 4) uniform sampler2D radiance;
layout(binding = 5) uniform sampler2D history;
layout(scalar, binding = 6) readonly buffer PreviousView { TaaView data; } previous_view;
layout(scalar, binding = 7) readonly buffer View { TaaView data; } view;
layout(binding = 8, rgba32f) uniform writeonly image2D accumulated;

/// Where the last frame saw a point, in pixels; y points down.
vec2 seen_before(vec3 world) {
    TaaView old = previous_view.data;
    vec3 d = world - old.position;
    vec2 across = vec2(dot(d, old.right) / dot(old.right, old.right), dot(d, old.up) / dot(old.up, old.up));
    vec2 ndc = frame.data.orthographic != 0u ? across : across / dot(d, old.forward);
    return (0.5 + vec2(0.5, -0.5) * ndc) * vec2(frame.data.picture);
}

/// Linear interpolation by hand: not all devices filter 32-bit floats.
vec4 interpolate(vec2 position) {
    ivec2 limit = ivec2(frame.data.size) - 1;
    vec2 corner = floor(position - 0.5), weight = position - 0.5 - corner;
    ivec2 low = clamp(ivec2(corner), ivec2(0), limit), high = clamp(ivec2(corner) + 1, ivec2(0), limit);
    return mix(mix(texelFetch(history, low, 0), texelFetch(history, ivec2(high.x, low.y), 0), weight.x),
        mix(texelFetch(history, ivec2(low.x, high.y), 0), texelFetch(history, high, 0), weight.x), weight.y);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = ivec2(frame.data.size);
    if (any(greaterThanEqual(pixel, size))) return;
    vec4 lowest = vec4(3.4e38), highest = vec4(-3.4e38);
    for (int i = 0; i < 9; ++i) {
        vec4 c = texelFetch(radiance, clamp(pixel + ivec2(i % 3 - 1, i / 3 - 1), ivec2(0), size - 1), 0);
        lowest = min(lowest, c);
        highest = max(highest, c);
    }
    vec4 current = texelFetch(radiance, pixel, 0);
    bool still = previous_view.data.position == view.data.position && previous_view.data.right == view.data.right &&
                 previous_view.data.up == view.data.up && previous_view.data.forward == view.data.forward;

    vec2 moved = seen_before(sample_world(pixel, view_depth(fetch_depth(pixel)))) - frame.data.jitter;
    bool seen = previous_view.data.frames > 0u && all(greaterThanEqual(moved, vec2(0.0))) &&
                all(lessThanEqual(moved, vec2(size)));
    vec4 followed = seen ? clamp(interpolate(moved), lowest, highest) : current;
    vec4 old = still ? texelFetch(history, pixel, 0) : followed;
    imageStore(accumulated, pixel, old + (current - old) / float(view.data.frames));
}

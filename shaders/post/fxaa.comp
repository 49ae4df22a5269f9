// SPDX-License-Identifier: Apache-2.0
// reads the displayed picture, its luma in alpha, and its radiance; writes radiance, each pixel on
// an edge moved towards the other side by what the edge's ends say that it covers.
//   offset = 1/2 - d_near / (d_near + d_far)      d: pixels along the edge to its two ends
// Lottes, FXAA, NVIDIA 2009; version 3.11's quality path with the steps of its preset 39.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "include/color.glsl"
#include "post/fxaa.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0) uniform sampler2D display;
layout(binding = 1) uniform sampler2D radiance;
layout(binding = 2, rgba32f) uniform writeonly image2D filtered;
layout(push_constant, scalar) uniform Push { FxaaPush push; };

/// Pixels walked by each step of the search for an edge's end: 28 at most.
const int kSteps = 12;
const float kStep[kSteps] = float[](1.0, 1.0, 1.0, 1.0, 1.0, 1.5, 2.0, 2.0, 2.0, 2.0, 4.0, 8.0);

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = textureSize(display, 0);
    if (any(greaterThanEqual(pixel, size))) return;

    float luma[9]; // rows of the neighbourhood, from the top
    for (int i = 0; i < 9; ++i) {
        ivec2 position = clamp(pixel + ivec2(i % 3 - 1, i / 3 - 1), ivec2(0), size - 1);
        luma[i] = texelFetch(display, position, 0).a;
    }
    float nw = luma[0], n = luma[1], ne = luma[2];
    float w = luma[3], m = luma[4], e = luma[5];
    float sw = luma[6], s = luma[7], se = luma[8];
    float highest = max(m, max(max(n, s), max(w, e)));
    float range = highest - min(m, min(min(n, s), min(w, e)));
    bool edge = range >= max(push.threshold_min, highest * push.threshold);

    // What is narrower than a pixel differs from the mean around it.
    float mean = (2.0 * (n + s + w + e) + nw + ne + sw + se) / 12.0;
    float contrast = clamp(abs(mean - m) / max(range, 1e-6), 0.0, 1.0);
    float smooth_contrast = contrast * contrast * (3.0 - 2.0 * contrast);
    float subpixel_offset = smooth_contrast * smooth_contrast * push.subpixel;

    float across_rows = abs(nw + sw - 2.0 * w) + 2.0 * abs(n + s - 2.0 * m) + abs(ne + se - 2.0 * e);
    float across_columns = abs(nw + ne - 2.0 * n) + 2.0 * abs(w + e - 2.0 * m) + abs(sw + se - 2.0 * s);
    bool horizontal = across_rows >= across_columns; // does the edge run?
    float before = horizontal ? n : w, after = horizontal ? s : e;
    bool towards_before = abs(before - m) >= abs(after - m);
    float side = towards_before ? -1.0 : 1.0;
    float edge_luma = 0.5 * (m + (towards_before ? before : after));
    float end_contrast = 0.25 * max(abs(before - m), abs(after - m));

    // Walks between the two rows or columns of pixels until their mean luma is no longer the edge's.
    vec2 texel = 1.0 / vec2(size);
    vec2 along = horizontal ? vec2(texel.x, 0.0) : vec2(0.0, texel.y);
    vec2 across = (horizontal ? vec2(0.0, texel.y) : vec2(texel.x, 0.0)) * side;
    vec2 center = (vec2(pixel) + 0.5) * texel;
    vec2 reached = vec2(0.0); // pixels walked backward, forward
    vec2 end_luma = vec2(0.0);
    bvec2 walking = bvec2(edge);
    for (int i = 0; i < kSteps && any(walking); ++i) {
        reached += mix(vec2(0.0), vec2(kStep[i]), walking);
        vec2 there = vec2(textureLod(display, center + 0.5 * across - reached.x * along, 0.0).a,
            textureLod(display, center + 0.5 * across + reached.y * along, 0.0).a);
        end_luma = mix(end_luma, there - edge_luma, walking);
        walking = bvec2(walking.x && abs(end_luma.x) < end_contrast, walking.y && abs(end_luma.y) < end_contrast);
    }
    float nearer = min(reached.x, reached.y);
    float end = reached.x < reached.y ? end_luma.x : end_luma.y;
    // An end that turns the other way belongs to the pixel across.
    bool turns_here = (end < 0.0) != (m < edge_luma);
    float edge_offset = turns_here ? 0.5 - nearer / max(reached.x + reached.y, 1.0) : 0.0;

    float offset = max(edge_offset, subpixel_offset);
    vec4 unfiltered = texelFetch(radiance, pixel, 0);
    vec3 moved = srgb_decode(textureLod(display, center + offset * across, 0.0).rgb);
    imageStore(filtered, pixel, edge ? vec4(moved, unfiltered.a) : unfiltered);
}

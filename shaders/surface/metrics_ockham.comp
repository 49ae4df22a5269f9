// SPDX-License-Identifier: Apache-2.0
// reads clusters of the window and lumas of S around the pixel; writes the variance that the pixel's n
// colours are expected to have (variance.glsl), before variance_pool.comp asks the neighbours:
//   x  w^2, within surfaces: what samples beyond the first of each surface average out
//   y  b^2 / (C - 1), between its C surfaces: what one sample of each removes, per sample
// Both of display-encoded luma. A prefix of the samples averages out either alike: x = w^2 + b^2,
// y = 0. S is the only shading known yet, one sample a pixel, so each surface
// of the window is looked for among the first samples of the neighbours: they show how bright it
// is, with its lights and shadows, and how much that varies.
//   own surface  w^2 = G (kEven + kBumpy s)            G: mean squared difference to the neighbours
//   others       w^2 = kOthers V                       V: variance of what the neighbours show of it
//   all          w^2 += Y^2 (kSlopes s^2 + kUnseen u + kRest r)    s: deviation of normals' slopes
// u, r: shares of the window on surfaces that no neighbour shows, and of what has no own label.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "shared/frame.h"
#include "surface/clusters.glsl"
#include "surface/metrics.h"
#include "surface/variance.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(scalar, binding = 0) uniform Frame { FrameData data; } frame;
#define SLOPES
#include "surface/surface_sample.glsl"
#ifdef WIDE
layout(binding = 4, rgba32ui) uniform readonly uimage2D clusters;
#else
layout(binding = 4, r32ui) uniform readonly uimage2D clusters;
#endif
layout(binding = 5, rgba8) uniform readonly image2D normal_spread;
layout(binding = 6, rg32ui) uniform readonly uimage2D first_surface;
layout(binding = 7, r32f) uniform readonly image2D first_luma;
layout(binding = 9, rg32f) uniform writeonly image2D lone_variance;
layout(push_constant, scalar) uniform Push { OckhamMetricsPush push; };

// Fitted once to the variance of all samples on five scenes (docs/passes/metrics_ockham.md).
const float kEven = 0.06;
const float kBumpy = 0.4;
const float kOthers = 0.3;
const float kSlopes = 0.04;
const float kUnseen = 0.01;
const float kRest = 0.18;
const float kUnseenContrast = 0.1;
const float kBetween = 4.0;
const float kReach = 1.5;        // pixels that a neighbour may lie off a surface's plane
const float kCancelled = 0.99;   // deviation of slopes from which normals count as cancelled
const float kMostVariance = 0.25; // that values in [0,1] can have

/// Neighbours: the direct ones first.
ivec2 neighbour(int i) {
    int j = i & 3;
    ivec2 direct = ivec2(j == 0 ? 1 : j == 1 ? -1 : 0, j == 2 ? 1 : j == 3 ? -1 : 0);
    return i < 4 ? direct : ivec2((i & 1) * 2 - 1, (i & 2) - 1);
}

float shown(ivec2 pixel) { return imageLoad(first_luma, pixel).x; }

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = ivec2(frame.data.size);
    if (any(greaterThanEqual(pixel, size))) return;
    uint m = frame.data.m, n = m * m;
    uvec4 labels = imageLoad(clusters, pixel);
#ifndef WIDE
    labels.yzw = uvec3(0u);
#endif
    uvec4 sizes = cluster_sizes(labels, n);
    uint count = cluster_count(sizes);
    vec4 share = vec4(sizes) / float(n);
    vec4 slopes = imageLoad(normal_spread, pixel);
    uvec2 surface = imageLoad(first_surface, pixel).xy;

    float here = shown(pixel);
    float squares = 0.0, seen = 0.0;
    for (int i = 0; i < 4; ++i) {
        ivec2 q = clamp(pixel + neighbour(i), ivec2(0), size - 1);
        bool same = imageLoad(first_surface, q).y == surface.y;
        float difference = abs(shown(q) - here);
        squares += same ? difference * difference : 0.0;
        seen += same && q != pixel ? 1.0 : 0.0;
    }
    // A background is one surface without variation, whatever is seen of it.
    bool background = surface.x == 0u;
    float within = background ? 0.0 : share.x * squares / max(seen, 1.0) * (kEven + kBumpy * slopes.x);

    // The other surfaces: a mean and a variance of the neighbours that show them.
    ivec2 first_offset = window_offset(int(frame.data.order[0]));
    float pixel_size = length(sample_right()) * float(m); // at view depth 1
    bool parallel = frame.data.orthographic != 0u;
    float far_distance = frame.data.far_distance;
    float means = share.x * here, mean_squares = share.x * here * here, known = share.x;
    for (uint label = 1u; label < count; ++label) {
        int index = int(frame.data.order[cluster_first_rank(labels, label)]);
        ivec2 position = pixel * int(m) + window_offset(index);
        SurfacePlane plane = fetch_plane(position);
        bool sky = !(plane.depth > 0.0);
        float reach = kReach * pixel_size * (parallel ? 1.0 / far_distance : plane.depth);
        float sum = 0.0, sum2 = 0.0, found = 0.0;
        for (int i = 0; i < 8; ++i) {
            ivec2 q = clamp(pixel + neighbour(i), ivec2(0), size - 1);
            uvec2 there = imageLoad(first_surface, q).xy;
            ivec2 at = q * int(m) + first_offset;
            float expected = plane.depth + dot(plane.slope, vec2(at - position));
            bool same = sky ? there.x == 0u
                            : there.x != 0u && there.y == plane.material && abs(uintBitsToFloat(there.x) - expected) <= reach;
            float y = shown(q);
            sum += same ? y : 0.0;
            sum2 += same ? y * y : 0.0;
            found += same ? 1.0 : 0.0;
        }
        float p = share[label], mean = sum / max(found, 1.0);
        float spread = max(sum2 - sum * mean, 0.0) / max(found - 1.0, 1.0);
        within += sky ? 0.0 : p * kOthers * spread;
        if (found > 0.0) {
            known += p;
            means += p * mean;
            mean_squares += p * mean * mean;
        }
    }
    float unseen = 1.0 - known;
    float between = max(mean_squares / known - means / known * means / known, 0.0);
    float energy = max(here * here, 0.05);
    between += kUnseenContrast * unseen * known * energy;
    within += here * here * (kSlopes * dot(share, slopes * slopes) + kUnseen * unseen + kRest * share.w);
    // Where surfaces differ, some variance within them never goes unpaid, however large the budget.
    within += 1e-4 * between;
    // Normals of one surface that cancel leave no direction to judge by.
    vec3 cancelled = vec3(greaterThan(slopes.xyz, vec3(kCancelled)));
    within = dot(cancelled, share.xyz) > 0.0 ? kMostVariance : within;
    vec2 expected = push.stratified != 0u ? pack_variance(within, kBetween * between, count) : vec2(within + between, 0.0);
    imageStore(lone_variance, pixel, expected.xyxy);
}

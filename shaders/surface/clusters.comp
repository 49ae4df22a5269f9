// SPDX-License-Identifier: Apache-2.0
// reads a pixel's window of the G-buffer; writes
//   clusters       labels of its samples (clusters.glsl)
//   normal_spread  per label: sqrt(1 / r - 1), r = |mean of its normals|, which is the deviation of
//                  their slopes; 1 where normals cancel
//   first_surface  stored depth (bits; 0: background) and material of the first sample
// One surface: the same material, and stored depth on the plane of its first sample,
//   |depth - plane| <= kReach pixels, and what the plane's own slope is rounded by.
// On a plane stored depth is linear over the picture, so nothing is fitted and no angle matters.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "shared/frame.h"
#include "surface/clusters.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(scalar, binding = 0) readonly buffer Frame { FrameData data; } frame;
#define SLOPES
#include "surface/surface_sample.glsl"
#ifdef WIDE
layout(binding = 4, rgba32ui) uniform writeonly uimage2D clusters;
#else
layout(binding = 4, r32ui) uniform writeonly uimage2D clusters;
#endif
layout(binding = 5, rgba8) uniform writeonly image2D normal_spread;
layout(binding = 6, rg32ui) uniform writeonly uimage2D first_surface;

const uint kBackground = 0xffffffffu;
const float kReach = 0.3;                 // pixels
const float kSlopeRounding = 1.0 / 512.0; // of fp16, over the widest window

/// Stored depth over the window, from its corner on: at + x * slope.x + y * slope.y.
struct Plane {
    uint material;
    float at;
    vec2 slope;
    float tolerance;
};

bool is_surface(float depth) { return depth > 0.0; } // and no NaN

Plane window_plane(SurfacePlane here, ivec2 offset) {
    if (!is_surface(here.depth)) return Plane(kBackground, 0.0, vec2(0.0), 0.0);
    float pixel = length(sample_right()) * float(frame.data.m); // at view depth 1
    float scale = frame.data.orthographic != 0u ? 1.0 / frame.data.far_distance : here.depth;
    float tolerance = kReach * pixel * scale + kSlopeRounding * (abs(here.slope.x) + abs(here.slope.y));
    return Plane(here.material, here.depth - dot(here.slope, vec2(offset)), here.slope, tolerance);
}

/// What is looked at of one sample. All background has one normal.
struct Sample {
    uint material;
    float depth;
    vec3 normal;
};

Sample fetch_sample(ivec2 position) {
    float depth = fetch_depth(position);
    Sample s = Sample(fetch_material(position), depth, fetch_normal(position));
    if (!is_surface(depth)) s = Sample(kBackground, 0.0, vec3(0.0, 0.0, 1.0));
    return s;
}

bool on_plane(Plane plane, Sample s, ivec2 offset) {
    return s.material == plane.material && abs(s.depth - plane.at - dot(plane.slope, vec2(offset))) <= plane.tolerance;
}

/// Deviation of slopes from the sum of `count` unit normals.
float spread(vec3 sum, uint count) {
    float r = length(sum) / float(max(count, 1u));
    return count == 0u ? 0.0 : sqrt(clamp(1.0 / max(r, 0.1) - 1.0, 0.0, 1.0));
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(frame.data.size)))) return;
    // Read once, and no division in loops: both cost software drivers a turn per lane.
    int m = int(frame.data.m), n = m * m;
    ivec2 corner = pixel * m;

    ivec2 first_offset = window_offset(int(frame.data.order[0]));
    SurfacePlane first = fetch_plane(corner + first_offset);
    Plane plane0 = window_plane(first, first_offset);
    bool single = true;
    vec3 sum0 = vec3(0.0);
    for (int y = 0; y < m; ++y) {
        for (int x = 0; x < m; ++x) {
            ivec2 offset = ivec2(x, y);
            Sample s = fetch_sample(corner + offset);
            single = single && on_plane(plane0, s, offset);
            sum0 += s.normal;
        }
    }

    // Most windows see one surface, and are done.
    Plane plane1 = plane0, plane2 = plane0;
    vec3 sum1 = vec3(0.0), sum2 = vec3(0.0), sum3 = vec3(0.0);
    sum0 = single ? sum0 : vec3(0.0);
    uvec4 labels = uvec4(0u);
    uint count = 1u;
    for (int rank = 0, last = single ? 0 : n; rank < last; ++rank) {
        ivec2 offset = window_offset(int(frame.data.order[rank]));
        Sample s = fetch_sample(corner + offset);
        uint label = rank == 0 || on_plane(plane0, s, offset)     ? 0u
                     : count > 1u && on_plane(plane1, s, offset) ? 1u
                     : count > 2u && on_plane(plane2, s, offset) ? 2u
                                                                   : 3u;
        // A surface not seen before; loops of one turn at most, since software drivers execute both
        // sides of a branch.
        for (bool open = label == 3u && count < 3u; open; open = false) {
            Plane plane = window_plane(fetch_plane(corner + offset), offset);
            if (count == 1u) plane1 = plane;
            else plane2 = plane;
            label = count++;
        }
        // The last label takes what the others leave over.
        if (label == 3u) count = 4u;
        sum0 += label == 0u ? s.normal : vec3(0.0);
        sum1 += label == 1u ? s.normal : vec3(0.0);
        sum2 += label == 2u ? s.normal : vec3(0.0);
        sum3 += label == 3u ? s.normal : vec3(0.0);
        labels[rank >> 4] |= label << 2 * (rank & 15);
    }

    uvec4 sizes = cluster_sizes(labels, uint(n));
    imageStore(clusters, pixel, labels);
    imageStore(normal_spread, pixel, vec4(spread(sum0, sizes.x), spread(sum1, sizes.y), spread(sum2, sizes.z), spread(sum3, sizes.w)));
    imageStore(first_surface, pixel, uvec4(plane0.material == kBackground ? 0u : floatBitsToUint(first.depth), plane0.material, 0u, 0u));
}

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

layout(scalar, binding = 0) uniform Frame { FrameData data; } frame;
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

/// What is read of the frame: once, since software drivers read a buffer lane by lane.
struct Window {
    ivec2 corner;
    int m;
    vec2 reach; // of a plane, in stored depth: x anywhere, y for a depth of 1
};

Window read_window(ivec2 pixel) {
    int m = int(frame.data.m);
    float pixel_reach = kReach * (length(sample_right()) * float(m)); // at view depth 1
    vec2 reach = frame.data.orthographic != 0u ? vec2(pixel_reach * (1.0 / frame.data.far_distance), 0.0)
                                               : vec2(0.0, pixel_reach);
    return Window(pixel * m, m, reach);
}

Plane window_plane(Window window, SurfacePlane here, ivec2 offset) {
    if (!is_surface(here.depth)) return Plane(kBackground, 0.0, vec2(0.0), 0.0);
    float tolerance = window.reach.x + window.reach.y * here.depth + kSlopeRounding * (abs(here.slope.x) + abs(here.slope.y));
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

// Sets of samples: a bit each.
#ifdef WIDE
#define Samples uvec2
#else
#define Samples uint
#endif
const Samples kNone = Samples(0u);

Samples set_of(uint sample_number) {
#ifdef WIDE
    return uvec2(sample_number < 32u ? 1u << sample_number : 0u, sample_number < 32u ? 0u : 1u << sample_number - 32u);
#else
    return 1u << sample_number;
#endif
}

/// The lowest number in a set that is not empty.
uint first_of(Samples set) {
#ifdef WIDE
    return set.x != 0u ? uint(findLSB(set.x)) : 32u + uint(findLSB(set.y));
#else
    return uint(findLSB(set));
#endif
}

/// Bits 0 ... 15 of a word on its even bits.
uint spaced(uint bits) {
    bits = (bits | bits << 8) & 0x00ff00ffu;
    bits = (bits | bits << 4) & 0x0f0f0f0fu;
    bits = (bits | bits << 2) & 0x33333333u;
    return (bits | bits << 1) & 0x55555555u;
}

/// Labels of 16 samples from their low and high bits.
uint label_word(uint low, uint high) { return spaced(low) | spaced(high) << 1; }

/// Place of a sample in the window. No division: software drivers take a turn per lane for it.
ivec2 ranked_offset(Window window, uint rank) {
    int index = int(frame.data.order[rank]);
    int row = int((float(index) + 0.5) / float(window.m));
    return ivec2(index - row * window.m, row);
}

/// The samples of `rest` on the surface of the first of them, and the sum of their normals.
Samples take_surface(Window window, Samples rest, out vec3 sum) {
    Samples taken = kNone;
    sum = vec3(0.0);
    // Loops rather than branches, of which software drivers execute both sides; the outer one turns
    // once.
    for (bool any_left = rest != kNone; any_left; any_left = false) {
        uint first = first_of(rest);
        ivec2 first_offset = ranked_offset(window, first);
        Plane plane = window_plane(window, fetch_plane(window.corner + first_offset), first_offset);
        for (Samples todo = rest; todo != kNone;) {
            uint rank = first_of(todo);
            todo &= ~set_of(rank);
            ivec2 offset = ranked_offset(window, rank);
            Sample s = fetch_sample(window.corner + offset);
            bool on = rank == first || on_plane(plane, s, offset);
            taken |= on ? set_of(rank) : kNone;
            sum += on ? s.normal : vec3(0.0);
        }
    }
    return taken;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(frame.data.size)))) return;
    Window window = read_window(pixel);
    uint n = uint(window.m * window.m);

    ivec2 first_offset = ranked_offset(window, 0u);
    SurfacePlane first = fetch_plane(window.corner + first_offset);
    Plane plane = window_plane(window, first, first_offset);
    // Row by row, without the order, which most windows need not know.
    uint first_index = uint(first_offset.x + first_offset.y * window.m);
    Samples off = kNone; // by index
    vec3 sum0 = vec3(0.0), sum1, sum2, sum3 = vec3(0.0);
    uint index = 0u;
    for (int y = 0; y < window.m; ++y) {
        for (int x = 0; x < window.m; ++x, ++index) {
            Sample s = fetch_sample(window.corner + ivec2(x, y));
            bool on = index == first_index || on_plane(plane, s, ivec2(x, y));
            off |= on ? kNone : set_of(index);
            sum0 += on ? s.normal : vec3(0.0);
        }
    }
    Samples rest = kNone;
    for (uint rank = 0u, last = off == kNone ? 0u : n; rank < last; ++rank) {
        rest |= (off & set_of(frame.data.order[rank])) == kNone ? kNone : set_of(rank);
    }

    // Most windows see one surface, and are done. The last label has what the others leave over.
    Samples taken1 = take_surface(window, rest, sum1);
    rest &= ~taken1;
    Samples taken2 = take_surface(window, rest, sum2);
    rest &= ~taken2;
    for (Samples todo = rest; todo != kNone;) {
        uint rank = first_of(todo);
        todo &= ~set_of(rank);
        sum3 += fetch_sample(window.corner + ranked_offset(window, rank)).normal;
    }

    Samples low = taken1 | rest, high = taken2 | rest;
#ifdef WIDE
    uvec4 labels = uvec4(label_word(low.x & 0xffffu, high.x & 0xffffu), label_word(low.x >> 16, high.x >> 16),
        label_word(low.y & 0xffffu, high.y & 0xffffu), label_word(low.y >> 16, high.y >> 16));
#else
    uvec4 labels = uvec4(label_word(low, high), 0u, 0u, 0u);
#endif
    uvec4 sizes = cluster_sizes(labels, n);
    imageStore(clusters, pixel, labels);
    imageStore(normal_spread, pixel, vec4(spread(sum0, sizes.x), spread(sum1, sizes.y), spread(sum2, sizes.z), spread(sum3, sizes.w)));
    imageStore(first_surface, pixel, uvec4(plane.material == kBackground ? 0u : floatBitsToUint(first.depth), plane.material, 0u, 0u));
}

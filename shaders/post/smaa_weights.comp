// SPDX-License-Identifier: Apache-2.0
// reads edges; writes how much of each pixel belongs to the other side of its top and left edge.
//   x  of this pixel, to the one above    y  of the one above, to this one
//   z  of this pixel, to the left one     w  of the left one, to this one
// An edge with its crossing edges at both ends stands for a straight line: from half a pixel beside
// the one end to half a pixel beside the other, or to the edge's middle and back. Where crossing
// edges go on, there is a corner, which keeps most of its pixels. Edges of one or two pixels may be
// steps of a diagonal, whose line is as long as its steps alternate. Weights are the areas between
// line and edge, integrated here instead of looked up.
// Jimenez et al., SMAA, Eurographics 2012, sections 3 and 4; Reshetov, MLAA, HPG 2009.
#version 460
#extension GL_GOOGLE_include_directive : require

#include "post/smaa.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0) uniform usampler2D edges;
layout(binding = 1, rgba16f) uniform writeonly image2D weights;

/// Outside the picture there are no edges, and along its border none was found.
uint edges_at(ivec2 position) {
    ivec2 inside = clamp(position, ivec2(0), textureSize(edges, 0) - 1);
    return inside == position ? texelFetch(edges, position, 0).x : 0u;
}

/// Area above (x) and below (y) zero of the straight line from (u0, h0) to (u1, h1), u0 < u1, over
/// the part of [from, from + 1] where it is.
vec2 line_area(float u0, float h0, float u1, float h1, float from) {
    float a = clamp(from, u0, u1), b = clamp(from + 1.0, u0, u1);
    float slope = (h1 - h0) / (u1 - u0);
    float ha = h0 + slope * (a - u0), hb = h0 + slope * (b - u0);
    float above_a = max(ha, 0.0), above_b = max(hb, 0.0);
    float below_a = max(-ha, 0.0), below_b = max(-hb, 0.0);
    // Where the line crosses zero between a and b, each triangle has the share of its own height.
    float crossing = ha * hb < 0.0 ? 1.0 / (abs(ha) + abs(hb)) : 0.0;
    vec2 ends = vec2(above_a + above_b, below_a + below_b);
    return 0.5 * (b - a) * (crossing > 0.0 ? ends * ends * crossing : ends);
}

/// Half a pixel to the side where the crossing edge is; 0 where there is none or one on each.
float end_height(bool before, bool after) { return 0.5 * (float(before) - float(after)); }

/// Edges between the lattice points around pixels: the pixel (0, 0) has its edges along x and y from
/// the point (0, 0) on. The one from `at` by the unit step `to`.
bool edge_from(ivec2 at, ivec2 to) {
    ivec2 pixel = at + min(to, ivec2(0));
    return (edges_at(pixel) & (to.x != 0 ? SMAA_EDGE_TOP : SMAA_EDGE_LEFT)) != 0u;
}

/// Whether the edge that came by `last` to the lattice point `at` turns there, by `next`, and does
/// nothing else.
bool turns(ivec2 at, ivec2 last, ivec2 next) {
    return edge_from(at, next) && !edge_from(at, -next) && !edge_from(at, last);
}

/// Where the line of a diagonal ends, which steps by `last`, to the lattice point `at`, by `next`, by
/// `last` and so on. An edge of two pixels ends it in its middle, for straight lines have some among
/// single ones; before longer edges, which have a line of their own, it ends in the middle of a step.
vec2 diagonal_end(ivec2 at, ivec2 last, ivec2 next) {
    vec2 end = vec2(at) - 0.5 * vec2(last);
    bool going = turns(at, last, next);
    for (int i = 0; i < SMAA_DIAGONAL_REACH && going; ++i) {
        ivec2 to = at + next;
        bool single = turns(to, next, last);
        bool pair = edge_from(to, next) && !edge_from(to, last) && !edge_from(to, -last) && turns(to + next, next, last);
        end = single ? vec2(at) + 0.5 * vec2(next) : pair ? vec2(to) : end;
        going = single;
        at = to;
        ivec2 before = last;
        last = next;
        next = before;
    }
    return end;
}

/// Weights of one edge of the pixel. `along`: unit step along the edge, `across`: unit step from it
/// into the pixel; `edge` and `cross_edge`: bits of edges in this and the other direction.
vec2 edge_weights(ivec2 pixel, ivec2 along, ivec2 across, uint edge, uint cross_edge) {
    bool present = (edges_at(pixel) & edge) != 0u;
    // Pixels from here to where the edge or the search ends, and the crossing edges there.
    int reach[2];
    uvec2 crossing[2]; // beside: before, after the edge
    for (int side = 0; side < 2; ++side) {
        ivec2 forward = side == 0 ? -along : along;
        // The boundary of a pixel backward is its own cross edge, forward that of the next one.
        ivec2 boundary = side == 0 ? ivec2(0) : along;
        bool walking = present;
        reach[side] = 0;
        crossing[side] = uvec2(0u);
        for (int i = 0; i <= SMAA_REACH && walking; ++i) {
            ivec2 here = pixel + i * forward;
            crossing[side] = uvec2(edges_at(here + boundary - across), edges_at(here + boundary)) & cross_edge;
            bool goes_on = (edges_at(here + forward) & edge) != 0u;
            walking = crossing[side] == uvec2(0u) && goes_on && i < SMAA_REACH;
            reach[side] += walking ? 1 : 0;
        }
    }
    bvec2 start = notEqual(crossing[0], uvec2(0u)), end = notEqual(crossing[1], uvec2(0u));
    float h0 = end_height(start.x, start.y), h1 = end_height(end.x, end.y);

    // Of a corner, the crossing edge goes on; the nearer end decides, at the middle both.
    ivec2 fall = h0 > 0.0 ? across : -across, rise = h1 > 0.0 ? across : -across;
    ivec2 start_at = pixel - reach[0] * along, end_at = pixel + (reach[1] + 1) * along;
    bvec2 corner = bvec2(h0 != 0.0 && edge_from(start_at - fall, -fall), h1 != 0.0 && edge_from(end_at - rise, -rise));
    vec2 nearer = vec2(reach[0] <= reach[1], reach[1] <= reach[0]);
    float kept = 1.0 - (1.0 - SMAA_CORNER) * dot(nearer, vec2(corner)) / (nearer.x + nearer.y);

    // The line of a diagonal, from this edge's start. In an edge of two pixels it passes the middle.
    bool steps = present && h0 * h1 < 0.0 && reach[0] + reach[1] < 2;
    vec2 from = vec2(0.0), to = vec2(along);
    if (steps && reach[0] == 0) from = diagonal_end(pixel, -along, -fall) - vec2(pixel);
    if (steps && reach[1] == 0) to = diagonal_end(pixel + along, along, fall) - vec2(pixel);
    float u0 = dot(from, vec2(along)), u1 = dot(to, vec2(along));
    bool diagonal = steps && u0 <= 0.0 && u1 >= 1.0;
    vec2 slanted = diagonal ? line_area(u0, -dot(from, vec2(across)), u1, -dot(to, vec2(across)), 0.0) : vec2(0.0);

    // Crossing edges on both sides of one end continue the line of the other end.
    if (all(start)) h0 = -h1;
    if (all(end)) h1 = -h0;

    float length = float(reach[0] + reach[1] + 1), at = float(reach[0]);
    vec2 straight = line_area(0.0, h0, length, h1, at);
    vec2 bent = line_area(0.0, h0, 0.5 * length, 0.0, at) + line_area(0.5 * length, 0.0, length, h1, at);
    // Above the edge lies what the pixel before it loses; below, what this one does.
    vec2 area = diagonal ? slanted : kept * (h0 * h1 < 0.0 ? straight : bent);
    return present ? area.yx : vec2(0.0);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, textureSize(edges, 0)))) return;
    vec2 top = edge_weights(pixel, ivec2(1, 0), ivec2(0, 1), SMAA_EDGE_TOP, SMAA_EDGE_LEFT);
    vec2 left = edge_weights(pixel, ivec2(0, 1), ivec2(1, 0), SMAA_EDGE_LEFT, SMAA_EDGE_TOP);
    imageStore(weights, pixel, vec4(top, left));
}

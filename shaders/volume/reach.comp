// SPDX-License-Identifier: Apache-2.0
// One axis of three of a distance transform (Chebyshev): how far from an empty cell the nearest one
// is that holds something, along each axis and diagonally.
//   reads from: opacity where > 0; else minus the distance over the axes before
//   writes to: the same with this axis; after the last, minus how many cells all around are empty too
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "volume/reach.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(scalar, binding = 10) readonly buffer From { float cells[]; } from;
layout(scalar, binding = 11) writeonly buffer To { float cells[]; } to;
layout(push_constant, scalar) uniform Push { ReachPush push; };

const int kFarthest = 16; // cells; nobody looks further

void main() {
    uvec3 cell = gl_GlobalInvocationID;
    if (any(greaterThanEqual(cell, push.cells))) return;
    uvec3 strides = uvec3(1u, push.cells.x, push.cells.x * push.cells.y);
    uint index = cell.x + cell.y * strides.y + cell.z * strides.z;
    int place = int(cell[push.axis]), last = int(push.cells[push.axis]) - 1;
    int first = int(index) - place * int(strides[push.axis]);

    int distance = kFarthest;
    for (int i = max(place - kFarthest, 0); i <= min(place + kFarthest, last); ++i) {
        float other = from.cells[first + i * int(strides[push.axis])];
        int before = other > 0.0 ? 0 : push.axis == 0u ? kFarthest : int(-other);
        distance = min(distance, max(abs(i - place), before));
    }
    float opacity = from.cells[index];
    to.cells[index] = opacity > 0.0 ? opacity : float(push.axis == 2u ? 1 - distance : -distance);
}

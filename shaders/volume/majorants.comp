// SPDX-License-Identifier: Apache-2.0
// reads frame, transfer, opacity_max, ranges; writes majorants: per cell
//   max over v in range of opacity(v) = max(opacity at the ends, entries of the table in between),
// the entries by two overlapping runs of 2^level of them (sparse table of Bender and Farach-Colton
// 2000). A little wider than exact, since lookups and interpolation round.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "shared/volume.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(scalar, binding = 0) uniform Frame { VolumeFrame data; } frame;
layout(scalar, binding = 2) readonly buffer Transfer { vec4 entries[]; } transfer;
layout(scalar, binding = 4) readonly buffer Ranges { vec2 cells[]; } ranges;
layout(scalar, binding = 10) readonly buffer OpacityMax { float levels[]; } opacity_max;
layout(scalar, binding = 11) writeonly buffer Majorants { float cells[]; } majorants;

const float kRounding = 4.76837158e-7; // 2^-21: eight units in the last place, or four

float opacity_at(float place) {
    uint entry = min(uint(place), frame.data.table_size - 2u);
    return mix(transfer.entries[entry].w, transfer.entries[entry + 1u].w, place - float(entry));
}

float greatest(uint first, uint last) {
    int level = findMSB(last - first + 1u);
    uint run = uint(level) * frame.data.table_size;
    return max(opacity_max.levels[run + first],
        opacity_max.levels[run + last + 1u - (1u << level)]);
}

void main() {
    uvec3 cell = gl_GlobalInvocationID;
    uvec3 cells = frame.data.cells;
    if (any(greaterThanEqual(cell, cells))) return;
    uint index = (cell.z * cells.y + cell.y) * cells.x + cell.x;

    vec2 range = ranges.cells[index];
    range += vec2(-kRounding, kRounding) * max(abs(range.x), abs(range.y));
    // As table_place() of medium.glsl: monotonic, whatever it rounds.
    vec2 place = clamp((range - frame.data.table_first) * frame.data.table_scale, 0.0,
        float(frame.data.table_size - 1u));
    float opacity = max(opacity_at(place.x), opacity_at(place.y));
    uint first = uint(ceil(place.x)), last = uint(floor(place.y));
    if (first <= last) opacity = max(opacity, greatest(first, last));
    majorants.cells[index] = opacity * (1.0 + kRounding);
}

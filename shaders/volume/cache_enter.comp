// SPDX-License-Identifier: Apache-2.0
// reads cache_index and cache_cells; fills the working set with the block of slots that begins:
// cache_sums at zero, with the opacity of each cell as its contribution, cache_paths with no path under
// way. Where readers see an older value, they go on with it for a while; else any value is better.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "volume/medium.glsl"
#include "volume/cache_geometry.glsl"

layout(local_size_x = 64) in;

layout(scalar, binding = 8) readonly buffer CacheIndex { CacheHeader header; uint words[]; } cache_index;
layout(scalar, binding = 9) readonly buffer CacheCells { uint words[]; } cache_cells;
layout(scalar, binding = 10) readonly buffer Control { CacheControl data; } cache_control;
layout(scalar, binding = 11) writeonly buffer Sums { CacheSum items[]; } cache_sums;
layout(scalar, binding = 12) writeonly buffer Paths { CachePath items[]; } cache_paths;
layout(push_constant, scalar) uniform Push { CachePush push; };

/// 1 - exp(-sigma h) with the mean extinction at 2 x 2 x 2 places and the cell's side h, above 0:
/// cells without opacity of their own are interpolated with those that have some.
float contribution_of(uvec3 cell) {
    vec3 low, high;
    cache_bounds(cell, push.scale, low, high);
    float sigma = 0.0;
    for (uint i = 0u; i < 8u; ++i) {
        vec3 fraction = vec3(i & 1u, i >> 1u & 1u, i >> 2u) * 0.5 + 0.25;
        sigma += 0.125 * medium_of(field(mix(low, high, fraction))).sigma_t;
    }
    float volume_world = abs(determinant(frame.data.world_from_unit)) /
        (float(frame.data.dims.x) * float(frame.data.dims.y) * float(frame.data.dims.z));
    float side = float(push.scale) * pow(volume_world, 1.0 / 3.0);
    return max(1.0 - exp(-sigma * side), 1.0 / 64.0);
}

void main() {
    uint i = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 64u + gl_LocalInvocationIndex;
    CacheHeader header = cache_index.header;
    uint first = cache_control.data.block * push.set;
    uint slots = min(header.slots, push.capacity);
    CacheSum empty = CacheSum(vec3(0.0), 0.0, vec3(0.0), 0u, CACHE_NONE, CACHE_NONE, 0.0, 0u, 0u, 0u);
    if (i < push.places) cache_paths.items[i].owner = 0u;
    if (i < push.set && first + i >= slots) cache_sums.items[i] = empty; // the last block may be short

    if (i >= header.cells.x * header.cells.y * header.cells.z) return;
    uint word = cache_index.words[i];
    if (word == CACHE_NONE) return;
    uint slot = word & CACHE_SLOT_MASK;
    if (slot < first || slot - first >= push.set) return;
    CacheSum sum = empty;
    if (word >> CACHE_PLACE_SHIFT != CACHE_PLACE_SOLID) {
        sum.cell = i;
        sum.word = word;
        bool old = cache_cells.words[slot * header.words] != CACHE_UNREFINED;
        sum.least = old ? CACHE_REPLACE_PATHS : 1u;
        sum.contribution = contribution_of(cache_cell(i, header.cells));
    }
    cache_sums.items[slot - first] = sum;
}

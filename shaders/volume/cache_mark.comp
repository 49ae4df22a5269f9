// SPDX-License-Identifier: Apache-2.0
// reads cache_pieces; writes into cache_index which cells get a slot, and the point that stands for
// each; writes cache_runs: how many do in a run of CACHE_RUN cells, and how many of them are solid.
// A cell is needed if composition may read it: if something can be seen within half a cell of it.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "volume/medium.glsl"
#include "volume/cache_geometry.glsl"

layout(local_size_x = 64) in;

layout(scalar, binding = 10) readonly buffer Pieces { CachePieces items[]; } cache_pieces;
layout(scalar, binding = 11) writeonly buffer CacheIndex { CacheHeader header; uint words[]; } cache_index;
layout(scalar, binding = 12) writeonly buffer Runs { uvec2 items[]; } cache_runs;
layout(push_constant, scalar) uniform Push { CachePush push; };

/// Whether a bit of first ... last (at most 32 apart) is set in two words that follow each other.
bool any_bit(uint low_word, uint high_word, uint first, uint last) {
    uint mask = (2u << last - first) - 1u, shift = first & 31u;
    uint bits = low_word >> shift | (shift == 0u ? 0u : high_word << 32u - shift);
    return (bits & mask) != 0u;
}

struct Around {
    bool visible, open, crossing;
};
/// What the pieces say that meet a cell (open) or lie within half a cell of it.
Around look_around(ivec3 cell) {
    int scale = int(push.scale), half_scale = scale / 2;
    ivec3 last_piece = ivec3(frame.data.dims);
    ivec3 first = max(cell * scale - half_scale, ivec3(0));
    ivec3 last = min(cell * scale + scale + half_scale, last_piece);
    ivec3 inner_first = cell * scale, inner_last = min(cell * scale + scale, last_piece);
    uint row_words = (frame.data.dims.x + 32u) / 32u;
    Around found = Around(false, false, false);
    for (int z = first.z; z <= last.z; ++z) {
        for (int y = first.y; y <= last.y; ++y) {
            uint row = (uint(z) * (frame.data.dims.y + 1u) + uint(y)) * row_words;
            uint at = uint(first.x) / 32u;
            CachePieces low = cache_pieces.items[row + at];
            CachePieces high = cache_pieces.items[row + min(at + 1u, row_words - 1u)];
            found.visible = found.visible || any_bit(low.visible, high.visible, first.x, last.x);
            found.crossing = found.crossing || any_bit(low.crossing, high.crossing, first.x, last.x);
            bool inner = y >= inner_first.y && y <= inner_last.y && z >= inner_first.z && z <= inner_last.z;
            if (!inner || found.open) continue;
            at = uint(inner_first.x) / 32u;
            low = cache_pieces.items[row + at];
            high = cache_pieces.items[row + min(at + 1u, row_words - 1u)];
            found.open = any_bit(low.open, high.open, inner_first.x, inner_last.x);
        }
    }
    return found;
}

/// Of the 4 x 4 x 4 places of a cell the one nearest to the centre that is not in the solid and not
/// behind a clip plane; the first of several. 64: there is none.
uint find_place(uvec3 cell, uint opaque) {
    vec3 low, high;
    cache_bounds(cell, push.scale, low, high);
    uint found = 64u, found_distance = 64u;
    for (uint place = 0u; place < 64u; ++place) {
        ivec3 from_centre = ivec3(place & 3u, place >> 2u & 3u, place >> 4u) * 2 - 3;
        uint distance = uint(from_centre.x * from_centre.x + from_centre.y * from_centre.y +
                             from_centre.z * from_centre.z);
        if (distance >= found_distance) continue;
        vec3 unit = cache_place(place, low, high);
        if ((cache_sides(unit) & opaque) != 0u || !cache_kept(unit)) continue;
        found = place;
        found_distance = distance;
    }
    return found;
}

/// A clip plane passes through the cell.
bool is_cut(uvec3 cell) {
    vec3 low, high;
    cache_bounds(cell, push.scale, low, high);
    for (uint corner = 0u; corner < 8u; ++corner)
        if (!cache_kept(mix(low, high, vec3(corner & 1u, corner >> 1u & 1u, corner >> 2u)))) return true;
    return false;
}

/// The word of the index, its slot still 0.
uint mark(uvec3 cell) {
    Around around = look_around(ivec3(cell));
    if (!around.visible) return CACHE_NONE;
    uint solid_word = push.hold_solid != 0u ? CACHE_PLACE_SOLID << CACHE_PLACE_SHIFT : CACHE_NONE;
    if (!around.open) return solid_word;
    bool cut = frame.data.clip_count > 0u && is_cut(cell);
    if (!around.crossing && !cut) return 0u;
    uint place = find_place(cell, push.occlusion != 0u ? cache_opaque_surfaces() : 0u);
    return place == 64u ? solid_word : CACHE_NEAR | place << CACHE_PLACE_SHIFT;
}

void main() {
    uvec3 grid = cache_grid(push.scale);
    uint cells = grid.x * grid.y * grid.z;
    uint run = gl_GlobalInvocationID.y * gl_NumWorkGroups.x * 64u + gl_GlobalInvocationID.x;
    if (run >= (cells + CACHE_RUN - 1u) / CACHE_RUN) return;
    uvec2 count = uvec2(0u);
    uint end = min((run + 1u) * CACHE_RUN, cells);
    for (uint i = run * CACHE_RUN; i < end; ++i) {
        uint word = mark(cache_cell(i, grid));
        cache_index.words[i] = word;
        if (word == CACHE_NONE) continue;
        ++count.x;
        if (word == CACHE_PLACE_SOLID << CACHE_PLACE_SHIFT) ++count.y;
    }
    cache_runs.items[run] = count;
}

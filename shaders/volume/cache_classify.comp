// SPDX-License-Identifier: Apache-2.0
// reads the volume and its transfer function; writes cache_pieces: a bit for each cube between eight
// voxel centres, whether it can be seen, is not all solid, and has a surface in it. The field there
// lies between the least and the greatest of the eight. One invocation writes 32 bits.
//   GRID  opacities differ, and opacity_max has the greatest of 2^level entries from each on
#version 460
#extension GL_GOOGLE_include_directive : require
#include "volume/medium.glsl"
#include "volume/cache_geometry.glsl"

layout(local_size_x = 64) in;

#ifdef GRID
layout(scalar, binding = 10) readonly buffer OpacityMax { float items[]; } opacity_max;
#endif
layout(scalar, binding = 11) writeonly buffer Pieces { CachePieces items[]; } cache_pieces;
layout(push_constant, scalar) uniform Push { CachePush push; };

/// Table entries, where rounding has not moved what is one of them.
float entry_of(float value) {
    uint entry;
    float fraction;
    table_place(value, entry, fraction);
    float x = float(entry) + fraction;
    return abs(x - round(x)) < 1e-3 ? round(x) : x;
}
float opacity_at(float entry) {
    uint low = uint(entry), high = min(low + 1u, frame.data.table_size - 1u);
    return mix(transfer.entries[low].w, transfer.entries[high].w, entry - float(low));
}
/// Whether anything from `low` to `high` has an opacity. Between entries it is linear.
bool shows(vec2 range) {
    float first = entry_of(range.x), last = entry_of(range.y);
    if (opacity_at(first) > 0.0 || opacity_at(last) > 0.0) return true;
#ifdef GRID
    uint from = uint(ceil(first)), to = uint(last);
    if (from >= to) return false;
    uint level = uint(findMSB(to - from));
    uint row = level * frame.data.table_size;
    return max(opacity_max.items[row + from], opacity_max.items[row + to - (1u << level)]) > 0.0;
#else
    return false;
#endif
}

/// Whether a piece lies at least partly inside the crop box and before every clip plane.
bool kept(uvec3 piece) {
    vec3 dims = vec3(frame.data.dims);
    vec3 low = (vec3(piece) - 0.5) / dims, high = (vec3(piece) + 0.5) / dims;
    if (any(lessThanEqual(high, frame.data.crop_min)) || any(greaterThanEqual(low, frame.data.crop_max)))
        return false;
    vec4 centre = vec4(world_from_unit(0.5 * (low + high)), 1.0);
    for (uint i = 0u; i < frame.data.clip_count; ++i) {
        vec4 plane = frame.data.clip_planes[i];
        vec3 reach = abs(plane.xyz * frame.data.world_from_unit) * 0.5 / dims;
        if (dot(plane, centre) + reach.x + reach.y + reach.z <= 0.0) return false;
    }
    return true;
}

/// Least and greatest of the four voxels of a column x, in rows y - 1, y and z - 1, z.
vec2 column(int x, ivec3 last, uvec3 piece) {
    vec2 range = vec2(kInfinity, -kInfinity);
    for (int i = 0; i < 4; ++i) {
        ivec3 voxel = clamp(ivec3(x, int(piece.y) - (i & 1), int(piece.z) - (i >> 1)), ivec3(0), last);
        float value = texelFetch(volume, voxel, 0).x;
        range = vec2(min(range.x, value), max(range.y, value));
    }
    return range;
}

void main() {
    uvec3 pieces = frame.data.dims + 1u;
    uint row_words = (pieces.x + 31u) / 32u;
    uint word = gl_GlobalInvocationID.y * gl_NumWorkGroups.x * 64u + gl_GlobalInvocationID.x;
    uvec3 piece = uvec3(word % row_words * 32u, word / row_words % pieces.y, word / (row_words * pieces.y));
    if (piece.z >= pieces.z) return;
    ivec3 last = ivec3(frame.data.dims) - 1;
    uint opaque = push.occlusion != 0u ? cache_opaque_surfaces() : 0u;
    uint surfaces = push.occlusion != 0u ? frame.data.surface_count : 0u;

    CachePieces bits = CachePieces(0u, 0u, 0u);
    vec2 before = column(int(piece.x) - 1, last, piece);
    uint end = min(piece.x + 32u, pieces.x);
    for (uint bit = 1u; piece.x < end; ++piece.x, bit <<= 1u) {
        vec2 here = column(int(piece.x), last, piece);
        vec2 range = vec2(min(before.x, here.x), max(before.y, here.y));
        before = here;
        bool solid = false, crossing = false;
        for (uint k = 0u; k < surfaces; ++k) {
            float value = frame.data.surfaces[k].value;
            solid = solid || ((opaque >> k & 1u) != 0u && range.x >= value);
            crossing = crossing || (range.x < value && range.y >= value);
        }
        if (kept(piece) && shows(range)) bits.visible |= bit;
        if (!solid) bits.open |= bit;
        if (crossing) bits.crossing |= bit;
    }
    cache_pieces.items[word] = bits;
}

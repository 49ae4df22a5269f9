// SPDX-License-Identifier: Apache-2.0
// reads the G-buffer, sample_count, tile_list; writes the sum of each pixel's k samples. One
// workgroup takes one tile: its (pixel, sample) pairs, pixel after pixel, are spread over the lanes
// in chunks, whoever's pixel they are of; then each lane adds up its own pixel's colours in order.
// CONTINUE adds to the sums of an earlier dispatch.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "schedule/tile_list.h"
#include "surface/shade_pixel.glsl"

#define LANES (BUCKET_TILE * BUCKET_TILE)
#define CHUNK (4 * LANES) // pairs; 13 KiB of shared memory in all

layout(local_size_x = LANES) in;
layout(scalar, binding = 10) readonly buffer TileList { uint count; uint items[]; } tile_list;
layout(binding = 12, r8ui) uniform readonly uimage2D sample_count;

shared uint pairs_up_to[LANES]; // of the pixels of lanes 0 ... this one
shared uint pair[CHUNK];        // lane of the pixel, index in the window << 8
shared float pair_widening[CHUNK];
shared float pair_weight[CHUNK];
shared float pair_roughening[CHUNK];
shared uint pair_albedo[CHUNK];
shared vec4 color[CHUNK];

/// Inclusive prefix sum over the lanes.
uint sum_up_to(uint lane, uint value) {
    pairs_up_to[lane] = value;
    barrier();
    for (uint stride = 1u; stride < LANES; stride *= 2u) {
        uint below = lane >= stride ? pairs_up_to[lane - stride] : 0u;
        barrier();
        pairs_up_to[lane] += below;
        barrier();
    }
    return pairs_up_to[lane];
}

void main() {
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    if (group >= tile_list.count) return; // all lanes alike
    uint lane = gl_LocalInvocationIndex;
    uint tile = tile_list.items[group];
    ivec2 corner = ivec2(tile & 0xffffu, tile >> 16) * BUCKET_TILE;
    ivec2 pixel = corner + ivec2(lane % BUCKET_TILE, lane / BUCKET_TILE);
    bool inside = all(lessThan(pixel, ivec2(frame.data.size)));
    uint k = inside ? imageLoad(sample_count, pixel).x : 0u;
    bool done = is_done(k);

    Picks picks;
    precise vec4 sum;
    uint wanted = 0u;
    if (!done) {
        picks = begin_picks(pixel, k);
        uint first;
        sum = begin_sum(pixel, k, picks, first);
        wanted = min(push.last, k) - first;
    }
    uint end = sum_up_to(lane, wanted);
    uint next = end - wanted; // this pixel's next pair, of all of the tile's
    uint total = pairs_up_to[LANES - 1u];

    for (uint base = 0u; base < total; base += CHUNK) {
        uint chunk = min(CHUNK, total - base);
        uint first = next;
        for (; next < min(end, base + chunk); ++next) {
            uint slot = next - base;
            Pick pick = next_pick(picks);
            pair[slot] = lane | pick.index << 8;
            pair_widening[slot] = pick.widening;
            pair_weight[slot] = pick.weight;
            pair_roughening[slot] = pick.roughening;
            pair_albedo[slot] = pick.albedo;
        }
        barrier();
        for (uint slot = lane; slot < chunk; slot += LANES) {
            uint owner = pair[slot] & 0xffu;
            ivec2 of = corner + ivec2(owner % BUCKET_TILE, owner / BUCKET_TILE);
            Pick pick = Pick(pair[slot] >> 8, pair_weight[slot], pair_widening[slot], pair_roughening[slot], pair_albedo[slot]);
            precise vec4 weighted = pick.weight * shade_sample(of, pick);
            color[slot] = weighted;
        }
        barrier();
        for (uint i = first; i < next; ++i) sum += color[i - base];
    }
    if (!done) imageStore(shaded_sum, pixel, sum);
}

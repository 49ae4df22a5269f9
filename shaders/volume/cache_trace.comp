// SPDX-License-Identifier: Apache-2.0
// reads the cells of one bucket, the medium, its surfaces and its light; adds paths to cache_sums.
// Paths begin at places in the cell that are outside the solid and see the point that stands for
// the cell, so that a cell which a wall divides stands for one side. What the loop budget interrupts
// waits in cache_paths for the next execution, or begins anew there. Sums are added in the order of the
// paths.
//   phi = mean of radiance,  F = mean of luminance times direction
#version 460
#extension GL_GOOGLE_include_directive : require
#define CELLS
#include "schedule/buckets.h"
#include "volume/medium.glsl"
#include "volume/path.glsl"
#include "volume/cache_geometry.glsl"

layout(local_size_x = BUCKET_GROUP) in;

layout(scalar, binding = 10) buffer Control { CacheControl data; } cache_control;
layout(scalar, binding = 11) buffer Sums { CacheSum items[]; } cache_sums;
layout(scalar, binding = 12) buffer Paths { CachePath items[]; } cache_paths;
layout(scalar, binding = 13) readonly buffer BucketTable { Bucket items[]; } bucket_table;
layout(scalar, binding = 14) readonly buffer PixelList { uint items[]; } pixel_list;
layout(push_constant, scalar) uniform Push { CachePush push; };

const uint kCellSeed = 0x9e3779b9u; // no cell shares its numbers with a pixel
const uint kPlaces = 8u;            // tried before a path begins at the representative itself

/// Where paths of a cell may begin.
struct Start {
    uint cell;
    vec3 low, high, representative;
    bool near;
};

bool owns(uint place, uint slot) { return atomicAdd(cache_paths.items[place].owner, 0u) == slot + 1u; }

/// Begins a path of number `index` at one more place, or leaves `path` ended: in the solid, unseen.
void try_start(Start start, uint index, uint tries, inout Path path, inout uint budget) {
    Random random = make_random(frame.data.seed ^ kCellSeed, start.cell, index);
    random.set = tries;
    vec4 xi = next4(random);
    vec3 unit = tries < kPlaces ? mix(start.low, start.high, xi.xyz) : start.representative;
    bool good = !start.near || cache_kept(unit);
#ifdef SURFACES
    if (start.near && good) good = cache_sees(unit, start.representative, budget) == kSeen;
#endif
    if (good) path = begin_cell_path(world_from_unit(unit), random);
}

void main() {
    Bucket bucket = bucket_table.items[push.bucket - 1u];
    uint item = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * BUCKET_GROUP + gl_LocalInvocationIndex;
    if (item >= bucket.count) return;
    uint word = pixel_list.items[bucket.first + item];
    uint slot = (word >> 16u) * CACHE_SET_WIDTH + (word & 0xffffu);

    CacheSum sum = cache_sums.items[slot];
    uint place = slot % push.places;
    bool kept = owns(place, slot);
    CachePath state = cache_paths.items[place];
    if (!kept) {
        state.path.stage = PATH_ENDED;
        state.tries = 0u;
    }
    Start start;
    uvec3 cell = cache_cell(sum.cell, cache_grid(push.scale));
    cache_bounds(cell, push.scale, start.low, start.high);
    start.representative = cache_representative(cell, push.scale, sum.word);
    start.near = (sum.word & CACHE_NEAR) != 0u;
    start.cell = sum.cell;

    Tracker tracker = resume(state.path);
    uint budget = push.iterations, done = 0u, bad = 0u;
    bool going = true;
    while (going && sum.owed > 0u && budget > 0u) {
        if (state.path.stage == PATH_ENDED) {
            going = done == 0u || budget >= push.iterations / 2u; // rather whole paths than halves
            if (!going) continue;
            --budget;
            state.path.radiance = vec3(0.0);
            uint index = sum.count + (sum.due > 0u ? sum.least : 0u);
            try_start(start, index, state.tries, state.path, budget);
            tracker = resume(state.path);
            state.first = state.path.direction;
            state.straight = vec3(0.0);
            state.to_light = state.path.to_light;
            if (state.path.stage == PATH_ENDED && state.tries++ < kPlaces) continue;
            state.tries = 0u;
        } else {
            advance(state.path, tracker, budget);
        }
        if (state.path.stage != PATH_ENDED) {
            if (state.path.bounces == 1u) state.straight = state.path.radiance;
            continue;
        }
        vec3 radiance = state.path.radiance;
        if (any(isnan(radiance)) || any(isinf(radiance))) { // never stored: it would be read for ever
            radiance = state.straight = vec3(0.0);
            ++bad;
        }
        float luminance = cache_luminance(radiance), straight = cache_luminance(state.straight);
        sum.radiance += radiance;
        sum.square += luminance * luminance;
        sum.flow += straight * state.to_light + (luminance - straight) * state.first;
        ++sum.count;
        --sum.owed;
        ++done;
    }
    suspend(state.path, tracker);
    cache_sums.items[slot] = sum;
    if (state.path.stage != PATH_ENDED || state.tries > 0u) {
        state.owner = slot + 1u;
        kept = kept || atomicCompSwap(cache_paths.items[place].owner, 0u, state.owner) == 0u;
        if (kept) cache_paths.items[place] = state;
    } else if (kept) {
        atomicExchange(cache_paths.items[place].owner, 0u);
    }

    // Statistics: whole numbers, so that their order does not matter.
    atomicAdd(cache_control.data.step_paths, done);
    atomicAdd(cache_control.data.step_events, tentative_collisions);
    if (sum.owed > 0u) atomicAdd(cache_control.data.step_resumed, 1u);
    if (clamped_collisions + bad > 0u) atomicAdd(cache_control.data.clamped, clamped_collisions + bad);
}

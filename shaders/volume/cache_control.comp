// SPDX-License-Identifier: Apache-2.0
// Where refinement goes next. One invocation.
//   RESTART  reads the header of cache_index: from the first block on
//   else     reads bucket_table: a block that no cell of got paths is done, and the next begins. Caches
//            of several blocks are gone through in rounds, the goal halved in each, until the target
//            is met: all rounds before the last cost a third of it, and light is everywhere soon.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "schedule/buckets.h"
#include "volume/cache.h"

layout(local_size_x = 8) in;

#ifdef RESTART
layout(scalar, binding = 8) readonly buffer CacheIndex { CacheHeader header; uint words[]; } cache_index;
layout(scalar, binding = 10) writeonly buffer Control { CacheControl data; } cache_control;
#else
layout(scalar, binding = 10) buffer Control { CacheControl data; } cache_control;
layout(scalar, binding = 13) readonly buffer BucketTable { Bucket items[]; } bucket_table;
#endif
layout(push_constant, scalar) uniform Push { CachePush push; };

const float kFirstGoal = 0.5;

/// Workgroups of 64 for `items`, at most 65,535 along an axis.
uvec3 groups_of(uint items) {
    uint groups = (items + 63u) / 64u, rows = (groups + 65534u) / 65535u;
    return rows == 0u ? uvec3(0u) : uvec3((groups + rows - 1u) / rows, rows, 1u);
}

#ifdef RESTART
CacheControl restarted() {
    CacheHeader header = cache_index.header;
    uint slots = min(header.slots, push.capacity);
    CacheControl c;
    c.blocks = (slots + push.set - 1u) / push.set;
    c.enter_groups = groups_of(max(push.cells, push.set));
    c.block = c.round = 0u;
    c.goal = c.blocks > 1u ? max(kFirstGoal, push.target) : push.target;
    c.suspended = 0u;
    c.cells = slots - min(slots, header.solid);
    c.unsettled = c.cells;
    c.steps = c.clamped = c.step_paths = c.step_resumed = c.step_events = 0u;
    c.paths = c.resumed = c.events = uvec2(0u);
    return c;
}
#else
uvec2 sum_of(uvec2 number, uint more) {
    uint carry;
    uint low = uaddCarry(number.x, more, carry);
    return uvec2(low, number.y + carry);
}

CacheControl stepped(CacheControl c) {
    c.paths = sum_of(c.paths, c.step_paths);
    c.resumed = sum_of(c.resumed, c.step_resumed);
    c.events = sum_of(c.events, c.step_events);
    c.step_paths = c.step_resumed = c.step_events = 0u;
    ++c.steps;
    c.enter_groups = uvec3(0u);
    c.unsettled = 0u;
    for (uint b = 1u; b < CACHE_BUCKETS; ++b) c.unsettled += bucket_table.items[b].count;
    if (c.unsettled > 0u || c.suspended != 0u) return c;

    if (c.block + 1u < c.blocks) {
        ++c.block;
    } else if (c.goal > push.target) {
        c.block = 0u;
        ++c.round;
        c.goal = max(0.5 * c.goal, push.target);
    } else {
        c.suspended = 1u;
        return c;
    }
    c.enter_groups = groups_of(max(push.cells, push.set));
    return c;
}
#endif

void main() {
    if (gl_LocalInvocationIndex != 0u) return;
#ifdef RESTART
    cache_control.data = restarted();
#else
    cache_control.data = stepped(cache_control.data);
#endif
}

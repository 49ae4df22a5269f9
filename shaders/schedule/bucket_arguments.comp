// SPDX-License-Identifier: Apache-2.0
// reads bucket_table counts; writes bucket_table firsts and the arguments of one indirect dispatch
// per bucket, and in one entry more those of all items of count 2 and more. A group count beyond
// 65535 spreads over two axes.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "schedule/buckets.h"

layout(local_size_x = 2 * MAX_BUCKETS) in;

layout(scalar, binding = 2) buffer BucketTable { Bucket items[]; } bucket_table;
layout(scalar, binding = 3) writeonly buffer BucketArguments { DispatchArguments items[]; } bucket_arguments;
layout(push_constant, scalar) uniform Push { BucketPush push; };

void main() {
    uint bucket = gl_LocalInvocationIndex;
    if (bucket > push.bucket_count) return;
    bool all_buckets = bucket == push.bucket_count;
    uint first = 0u, count = 0u;
    for (uint b = 0u; b < bucket; ++b) {
        uint items = bucket_table.items[b].count;
        if (all_buckets && b > 0u) count += items;
        else first += items;
    }
    if (!all_buckets) count = bucket_table.items[bucket].count;
    bucket_table.items[bucket].first = first;
    if (all_buckets) bucket_table.items[bucket].count = count;
    uint groups = (count + BUCKET_GROUP - 1u) / BUCKET_GROUP;
    uint rows = (groups + 65534u) / 65535u;
    bucket_arguments.items[bucket].x = rows == 0u ? 0u : (groups + rows - 1u) / rows;
    bucket_arguments.items[bucket].y = rows;
    bucket_arguments.items[bucket].z = 1u;
}

// SPDX-License-Identifier: Apache-2.0
// reads and writes budget_runs: sums become exclusive prefix sums. One workgroup.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "surface/budget.h"

layout(local_size_x = BUDGET_SCAN_WIDTH) in;

layout(scalar, binding = 3) buffer BudgetRuns { uint items[]; } budget_runs;
layout(push_constant, scalar) uniform Push { BudgetPush push; };

shared uint part_sum[BUDGET_SCAN_WIDTH];

void main() {
    uint runs = (push.size.x * push.size.y + push.run - 1u) / push.run;
    uint part = (runs + BUDGET_SCAN_WIDTH - 1u) / BUDGET_SCAN_WIDTH;
    uint lane = gl_LocalInvocationIndex, first = min(lane * part, runs), last = min(first + part, runs);
    uint sum = 0u;
    for (uint i = first; i < last; ++i) sum += budget_runs.items[i];
    part_sum[lane] = sum;
    barrier();
    for (uint stride = 1u; stride < BUDGET_SCAN_WIDTH; stride *= 2u) {
        uint below = lane >= stride ? part_sum[lane - stride] : 0u;
        barrier();
        part_sum[lane] += below;
        barrier();
    }
    uint before = part_sum[lane] - sum;
    for (uint i = first; i < last; ++i) {
        uint run = budget_runs.items[i];
        budget_runs.items[i] = before;
        before += run;
    }
}

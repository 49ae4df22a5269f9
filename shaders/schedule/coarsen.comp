// SPDX-License-Identifier: Apache-2.0
// reads fine_count; writes sample_count: of each block of pixels the largest count, then
//   k = min(2^ceil(log2 k), n)                    if rounded to powers of two
// Hollaender et al. 2013, section 4.2: the low-resolution count and the reduced co-domain. One
// invocation walks one block.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "schedule/coarsen.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0, r8ui) uniform readonly uimage2D fine_count;
layout(binding = 1, r8ui) uniform writeonly uimage2D sample_count;
layout(push_constant, scalar) uniform Push { CoarsenPush push; };

void main() {
    uvec2 corner = gl_GlobalInvocationID.xy * push.block;
    uvec2 end = min(corner + push.block, push.size);
    uint k = 1u;
    for (uint y = corner.y; y < end.y; ++y) {
        for (uint x = corner.x; x < end.x; ++x) k = max(k, imageLoad(fine_count, ivec2(x, y)).x);
    }
    // The highest bit of 2k - 1 stands at ceil(log2 k).
    if (push.powers_of_two != 0u) k = 1u << findMSB(2u * k - 1u);
    k = min(k, push.n);
    for (uint y = corner.y; y < end.y; ++y) {
        for (uint x = corner.x; x < end.x; ++x) imageStore(sample_count, ivec2(x, y), uvec4(k));
    }
}

// SPDX-License-Identifier: Apache-2.0
// Writes: each element of the target, a hash of all inputs, of the element's index, of its old value
// where that is read, and of the number of workgroups; any number of these covers the target.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "mix.glsl"

layout(local_size_x = 64) in;

void main() {
    const uvec3 groups = gl_NumWorkGroups;
    const uvec3 group = gl_WorkGroupID;
    const uint seed = push.seed + groups.x + 4 * groups.y + 16 * groups.z;
    const uint count = TARGET_COUNT;
    const uint first = ((group.z * groups.y + group.y) * groups.x + group.x) * 64 + gl_LocalInvocationID.x;
    for (uint i = first; i < count; i += 64 * groups.x * groups.y * groups.z)
        write_target(i, mix_inputs(seed, i, count));
}

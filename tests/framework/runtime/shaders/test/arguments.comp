// SPDX-License-Identifier: Apache-2.0
// Writes: arguments, two indirect dispatches: of 0 groups and of `groups` groups.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.h"

layout(local_size_x = 8) in;
layout(push_constant, scalar) uniform Push { uint groups; } push;
layout(binding = 0, scalar) writeonly buffer Arguments { uvec3 groups[]; } arguments;

void main() {
    if (gl_GlobalInvocationID.x != 0) return;
    arguments.groups[0] = uvec3(0, 1, 1);
    arguments.groups[1] = uvec3(push.groups, 1, 1);
}

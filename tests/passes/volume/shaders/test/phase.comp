// SPDX-License-Identifier: Apache-2.0
// reads queries: two random numbers, a cosine; writes answers: sample_phase() of the numbers,
// phase() of the cosine.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "include/phase.glsl"

layout(local_size_x = 64) in;

layout(scalar, binding = 10) readonly buffer Queries { vec3 items[]; } queries;
layout(scalar, binding = 11) writeonly buffer Answers { vec4 items[]; } answers;
layout(push_constant, scalar) uniform Push { vec3 forward; float g; } push;

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= queries.items.length()) return;
    vec3 query = queries.items[i];
    answers.items[i] =
        vec4(sample_phase(push.g, push.forward, query.xy), phase(push.g, query.z));
}

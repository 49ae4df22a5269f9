// SPDX-License-Identifier: Apache-2.0
// writes numbers: next4() of every stream, sample and set, sets fastest, then samples.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "include/random.glsl"

layout(local_size_x = 64) in;

layout(scalar, binding = 10) writeonly buffer Numbers { vec4 items[]; } numbers;
layout(push_constant, scalar) uniform Push { uint seed, streams, samples, first_sample, sets, first_set; } push;

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= push.streams * push.samples * push.sets) return;
    uint stream = i / (push.samples * push.sets);
    uint index = push.first_sample + i / push.sets % push.samples;
    Random random = make_random(push.seed, stream, index);
    random.set = push.first_set + i % push.sets;
    numbers.items[i] = next4(random);
}

// SPDX-License-Identifier: Apache-2.0
// reads from; writes to: the same words.
#version 460
#extension GL_EXT_scalar_block_layout : require

layout(local_size_x = 64) in;

layout(scalar, binding = 0) readonly buffer From { uint words[]; } from;
layout(scalar, binding = 1) writeonly buffer To { uint words[]; } to;

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < to.words.length()) to.words[i] = from.words[i];
}

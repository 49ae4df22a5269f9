// SPDX-License-Identifier: Apache-2.0
// reads keys; writes hashes: hash4() of each; numbers: open_unit() of each key.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "include/random.glsl"

layout(local_size_x = 64) in;

layout(scalar, binding = 10) readonly buffer Keys { uvec4 items[]; } keys;
layout(scalar, binding = 11) writeonly buffer Hashes { uvec4 items[]; } hashes;
layout(scalar, binding = 12) writeonly buffer Numbers { vec4 items[]; } numbers;

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= keys.items.length()) return;
    hashes.items[i] = hash4(keys.items[i]);
    numbers.items[i] = open_unit(keys.items[i]);
}

// SPDX-License-Identifier: Apache-2.0
// reads and writes the buffer's element `index`, which may lie beyond its end.
#version 460
#extension GL_EXT_scalar_block_layout : require

layout(local_size_x = 1) in;
layout(scalar, binding = 0) buffer Numbers { uint items[]; } numbers;
layout(push_constant, scalar) uniform Push { uint index; } push;

void main() {
    numbers.items[push.index] += 1u;
}

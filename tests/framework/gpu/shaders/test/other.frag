// SPDX-License-Identifier: Apache-2.0
// As pass.frag, but its binding 0 is not what pass.vert has there.
#version 460
layout(binding = 0) readonly buffer Colors { vec4 values[]; } colors;
layout(location = 0) out vec4 color;

void main() { color = colors.values[0]; }

// SPDX-License-Identifier: Apache-2.0
// Writes: color, from a buffer.
#version 460
layout(binding = 1) readonly buffer Colors { vec4 values[]; } colors;
layout(location = 0) out vec4 color;

void main() { color = colors.values[0]; }

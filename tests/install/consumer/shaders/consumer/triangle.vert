// SPDX-License-Identifier: Apache-2.0
// One triangle: the half of the picture above the diagonal from the lower left to the upper right.
#version 460

void main() {
    const vec2 corners[3] = {vec2(-1, -1), vec2(1, -1), vec2(-1, 1)};
    gl_Position = vec4(corners[gl_VertexIndex], 0.5, 1);
}

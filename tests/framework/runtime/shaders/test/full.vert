// SPDX-License-Identifier: Apache-2.0
// Reads nothing. One triangle over all of the picture.
#version 460

void main() {
    gl_Position = vec4(4.0 * (gl_VertexIndex & 1) - 1.0, 4.0 * (gl_VertexIndex >> 1) - 1.0, 0.5, 1.0);
}

// SPDX-License-Identifier: Apache-2.0
// Covers the picture with one triangle.
#version 460
layout(binding = 0) uniform sampler2D heights;

void main() {
    const vec2 corner = vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1) * 4.0 - 1.0;
    gl_Position = vec4(corner, texelFetch(heights, ivec2(0), 0).r, 1.0);
}

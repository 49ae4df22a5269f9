// SPDX-License-Identifier: Apache-2.0
// A triangle over the whole picture, and a hash of all inputs of this stage.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "mix.glsl"

layout(location = 0) flat out uint inputs;

void main() {
    inputs = mix_inputs(push.seed, 0, 1);
    gl_Position = vec4(4.0 * (gl_VertexIndex & 1) - 1.0, 2.0 * (gl_VertexIndex & 2) - 1.0, 0.5, 1.0);
}

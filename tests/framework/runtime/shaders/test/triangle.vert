// SPDX-License-Identifier: Apache-2.0
// Reads: vertices, one clip-space position each.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.h"

layout(push_constant, scalar) uniform Push { uint id; } push;
layout(binding = 0, scalar) readonly buffer Vertices { vec4 positions[]; } vertices;

void main() { gl_Position = vertices.positions[gl_VertexIndex]; }

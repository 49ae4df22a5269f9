// SPDX-License-Identifier: Apache-2.0
// One triangle over all of the picture, at the depth that stands for push.count samples.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "schedule/buckets.h"
#include "surface/shade.h"

layout(push_constant, scalar) uniform Push { ShadePush push; };

void main() {
    vec2 corner = vec2(4 * (gl_VertexIndex & 1) - 1, 4 * (gl_VertexIndex >> 1) - 1);
    gl_Position = vec4(corner, float(push.count) / float(MAX_BUCKETS), 1.0);
}

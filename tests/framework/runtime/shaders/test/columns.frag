// SPDX-License-Identifier: Apache-2.0
// Writes: id and coverage 0; depth (x + 1) / 16, or with STENCIL stencil x + 1.
#version 460
#ifdef STENCIL
#extension GL_ARB_shader_stencil_export : require
#endif

layout(location = 0) out uint id;
layout(location = 1) out float coverage;

void main() {
    id = 0u;
    coverage = 0.0;
#ifdef STENCIL
    gl_FragStencilRefARB = int(gl_FragCoord.x) + 1;
#else
    gl_FragDepth = (floor(gl_FragCoord.x) + 1.0) / 16.0;
#endif
}

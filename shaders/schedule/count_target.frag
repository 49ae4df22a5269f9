// SPDX-License-Identifier: Apache-2.0
// reads sample_count; writes it to the depth attachment, k / 64, exact in floating point, or with
// STENCIL to the stencil attachment: what later draws of one count are tested against.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#ifdef STENCIL
#extension GL_ARB_shader_stencil_export : require
#endif

#include "schedule/buckets.h"

layout(binding = 12, r8ui) uniform readonly uimage2D sample_count;

void main() {
    uint k = imageLoad(sample_count, ivec2(gl_FragCoord.xy)).x;
#ifdef STENCIL
    gl_FragStencilRefARB = int(k);
#else
    gl_FragDepth = float(k) / float(MAX_BUCKETS);
#endif
}

// SPDX-License-Identifier: Apache-2.0
// reads the G-buffer; writes the sum of each pixel's push.count samples, where the depth or stencil
// test lets it: Hollaender et al. 2013, section 4.2. CONTINUE adds to the sums of an earlier pass.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "surface/shade_pixel.glsl"

layout(early_fragment_tests) in; // else pixels of other counts would be written too

void main() { shade_pixel(ivec2(gl_FragCoord.xy), push.count); }

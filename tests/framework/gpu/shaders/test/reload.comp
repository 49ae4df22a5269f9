// SPDX-License-Identifier: Apache-2.0
// writes: result[i] = scale number() + bias
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "test/reload.glsl"

layout(constant_id = 0) const uint scale = 1;
layout(local_size_x = 8) in;
layout(push_constant, scalar) uniform Push { uint bias; } push;
layout(binding = 0, scalar) writeonly buffer Result { uint values[]; } result;

void main() { result.values[gl_GlobalInvocationID.x] = scale * number() + push.bias; }

// SPDX-License-Identifier: Apache-2.0
// An array of descriptors, which is refused.
#version 460

layout(local_size_x = 8) in;
layout(binding = 0) uniform sampler2D pictures[4];
layout(binding = 1, r32f) uniform writeonly image2D target;

void main() { imageStore(target, ivec2(0), texelFetch(pictures[1], ivec2(0), 0)); }

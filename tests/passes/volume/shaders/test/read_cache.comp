// SPDX-License-Identifier: Apache-2.0
// reads places (unit coordinates, then a direction) and the cache; writes light: what readers get.
#version 460
#extension GL_GOOGLE_include_directive : require
#define SURFACES // the frame may have none
#extension GL_EXT_scalar_block_layout : require

#include "volume/medium.glsl"
#include "volume/cache_lookup.glsl"

layout(local_size_x = 64) in;

layout(scalar, binding = 10) readonly buffer Places { vec3 items[]; } places;
layout(scalar, binding = 11) writeonly buffer Light { vec3 items[]; } light;

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (2u * i >= places.items.length()) return;
    uint budget = 1000u;
    light.items[i] = cached_in_scatter(places.items[2u * i], places.items[2u * i + 1u], budget);
}

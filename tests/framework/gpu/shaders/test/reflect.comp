// SPDX-License-Identifier: Apache-2.0
// One binding of each kind, for reflection; `unused` must not appear.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.h"

layout(constant_id = 3) const uint scale = 1;
layout(constant_id = 9) const uint bias = 0;
#ifdef SMALL
layout(local_size_x = 8) in;
#else
layout(local_size_x_id = 5, local_size_y = 4) in;
#endif

#ifndef NO_PUSH
layout(push_constant, scalar) uniform Push { vec3 direction; uint count; mat4x3 transform; } push;
#endif
layout(set = 1, binding = 2, scalar) readonly buffer Inputs { uint values[]; } inputs;
layout(set = 0, binding = 4, scalar) writeonly buffer Outputs { uint values_out[]; };
layout(set = 0, binding = 0, scalar) buffer Both { uint values[]; } both;
layout(set = 0, binding = 1, scalar) uniform Settings { uint limit; } settings;
layout(set = 0, binding = 2) uniform sampler2DArray layers;
layout(set = 0, binding = 3) uniform usampler3D volume;
layout(set = 0, binding = 5, rgba16f) uniform writeonly image2D target;
layout(set = 0, binding = 6, r32ui) uniform readonly uimage3D cells;
layout(set = 0, binding = 7, r32f) uniform image2DArray history;
layout(set = 3, binding = 0, scalar) readonly buffer Unused { uint values[]; } unused;

void main() {
    const uint i = gl_GlobalInvocationID.x;
    uint value = inputs.values[i] * scale + bias + settings.limit;
    value += uint(texelFetch(layers, ivec3(i, 0, 0), 0).r) + texelFetch(volume, ivec3(i), 0).r;
    value += imageLoad(cells, ivec3(i)).r;
    const vec4 old = imageLoad(history, ivec3(i));
    imageStore(history, ivec3(i), old + 1.0);
    imageStore(target, ivec2(i), old);
    both.values[i] += value;
    values_out[i] = value;
}

// SPDX-License-Identifier: Apache-2.0
// reads the first sample of each pixel; writes its normal and view depth, and its material.
// Background: normal 0, depth infinity, material NO_MATERIAL.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "debug/surface_aov.h"
#include "shared/frame.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(scalar, binding = 0) uniform Frame { FrameData data; } frame;
#include "surface/surface_sample.glsl"
layout(binding = 4, rgba32f) uniform writeonly image2D aov_surface;
layout(binding = 5, r32ui) uniform writeonly uimage2D aov_material;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(frame.data.size)))) return;
    ivec2 position = pixel * int(frame.data.m) + window_offset(int(frame.data.order[0]));
    SurfaceSample s = fetch_surface(position);
    bool hit = s.depth > 0.0;
    imageStore(aov_surface, pixel, hit ? vec4(s.normal, view_depth(s.depth)) : vec4(vec3(0.0), 1.0 / 0.0));
    imageStore(aov_material, pixel, uvec4(hit ? s.material : NO_MATERIAL));
}

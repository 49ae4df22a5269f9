// SPDX-License-Identifier: Apache-2.0
// reads a pixel's window of the G-buffer, its labels and the spread of its normals; writes
// surface_means (surface_means.glsl):
//   albedo  of each surface: the mean over all its samples, each looked up for itself
//   alpha^2 + 2 s^2, s: deviation of the normals' slopes, as a Gaussian lobe of slope variance s^2
//           has alpha^2 = 2 s^2 (Tokuyoshi and Kaplanyan, I3D 2019, section 3)
// Normals that spread far turn with the shape of things: widening fades out from kRough to 2 kRough,
// and there is none where a window sees several surfaces.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "include/footprint.glsl"
#include "shared/frame.h"
#include "surface/clusters.glsl"
#include "surface/material.glsl"
#include "surface/shade.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(constant_id = SPEC_DEMODULATE) const bool kDemodulate = false;
layout(scalar, binding = 0) uniform Frame { FrameData data; } frame;
#include "surface/surface_sample.glsl"
#ifndef VISIBILITY
layout(scalar, binding = 4) readonly buffer Materials { MaterialData items[]; } materials;
#endif
layout(binding = 5) uniform usampler2D clusters;
#ifdef COLOR_TEXTURES
layout(binding = 6) uniform sampler2DArray color_textures;
#endif
layout(binding = 7) uniform sampler2D normal_spread;
#ifdef COLOR_TEXTURES
layout(binding = 8, rgba32ui) uniform writeonly uimage2D surface_means;
#else
layout(binding = 8, r32ui) uniform writeonly uimage2D surface_means;
#endif
layout(push_constant, scalar) uniform Push { SurfaceMeansPush push; };

const float kRough = 0.1; // deviation of slopes: 6 degrees

vec3 fetch_albedo(ivec2 position) {
    SurfaceSample s = fetch_surface(position);
    MaterialData material = materials.items[is_iso_material(s.material) ? 0u : s.material];
    vec3 color = material.base_color.rgb * s.color;
#ifdef COLOR_TEXTURES
    TextureRef image = material.base_color_texture;
    if (image.layer >= 0) {
        TextureCoordinates c = s.coordinates[image.slot];
        color *= sample_footprint(color_textures, image.layer, image.size, c.uv, c.gradient_x, c.gradient_y, push.anisotropy).rgb;
    }
#endif
    return color;
}

uint pack_mean(vec4 sum) { return sum.w > 0.0 ? pack_color(sum.rgb / sum.w) : 0u; }

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(frame.data.size)))) return;
    int m = int(frame.data.m), n = m * m;
    ivec2 corner = pixel * m;
    uvec4 labels = texelFetch(clusters, pixel, 0);
    if (n <= 16) labels.yzw = uvec3(0u);

    vec4 sum0 = vec4(0.0), sum1 = vec4(0.0), sum2 = vec4(0.0);
    for (int rank = 0, last = kDemodulate ? n : 0; rank < last; ++rank) {
        ivec2 position = corner + window_offset(int(frame.data.order[rank]));
        vec4 color = fetch_depth(position) > 0.0 ? vec4(fetch_albedo(position), 1.0) : vec4(0.0);
        uint label = cluster_label(labels, uint(rank));
        sum0 += label == 0u ? color : vec4(0.0);
        sum1 += label == 1u ? color : vec4(0.0);
        sum2 += label == 2u ? color : vec4(0.0);
    }
    float spread = all(equal(labels, uvec4(0u))) ? texelFetch(normal_spread, pixel, 0).x : 0.0;
    float wider = 2.0 * spread * spread * clamp(2.0 - spread / kRough, 0.0, 1.0);
    imageStore(surface_means, pixel, uvec4(floatBitsToUint(wider), pack_mean(sum0), pack_mean(sum1), pack_mean(sum2)));
}

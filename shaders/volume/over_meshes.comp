// SPDX-License-Identifier: Apache-2.0
// reads the picture L of the meshes, and the means over N rays of how the medium changes it, D =
// L_medium - (1 - T) L_i, and of what it hides, a = 1 - T; writes the picture of both:
//   L + D - a (L - mean of L_i over these rays)
// The last term is 0 where the rays were those of all samples alike. Else what the medium hides would
// be missed by colours that these rays did not see. Where it is not in the way: L, bit for bit.
//   COMPOSED  N comes from compose_count, else from the paths' progress
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "volume/meshes.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0, rgba32f) uniform readonly image2D meshes;
layout(binding = 1, rgba32f) uniform readonly image2D change;
layout(binding = 2, rgba32f) uniform writeonly image2D picture;
#ifdef COMPOSED
layout(binding = 3, r32ui) uniform readonly uimage2D compose_count; // samples * 2, + 1
#else
layout(scalar, binding = 3) readonly buffer Progress { uvec2 pixels[]; } progress; // finished, wanted
#endif
layout(binding = 15) uniform usampler2D mesh_ends;
layout(binding = 17) uniform sampler2DArray mesh_radiance;
layout(push_constant, scalar) uniform Push { OverMeshesPush push; };

/// Of the sample of a rank: shaders/volume/mesh_ends.comp.
vec3 ray_radiance(ivec2 pixel, uint rank) {
    ivec2 at = pixel * int(push.window) + ivec2(rank % push.window, rank / push.window);
    return texelFetch(mesh_radiance, ivec3(pixel, texelFetch(mesh_ends, at, 0).x & 3u), 0).xyz;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(picture);
    if (any(greaterThanEqual(pixel, size))) return;
#ifdef COMPOSED
    uint count = max(imageLoad(compose_count, pixel).x >> 1u, 1u);
#else
    uint count = max(progress.pixels[pixel.y * size.x + pixel.x].x, 1u);
#endif
    // Of whole rounds the mean is right; those beyond are `more`.
    uint n = push.window * push.window, more = count % n;
    vec3 all = vec3(0.0), seen = vec3(0.0);
    for (uint rank = 0u; rank < (more > 0u ? n : 0u); ++rank) {
        vec3 radiance = ray_radiance(pixel, rank);
        all += radiance;
        seen += rank < more ? radiance : vec3(0.0);
    }
    vec3 missed = (float(more) / float(n) * all - seen) / float(count);
    vec4 mesh = imageLoad(meshes, pixel), by = imageLoad(change, pixel);
    imageStore(picture, pixel,
        vec4(mesh.rgb + by.rgb - by.a * missed, mesh.a + by.a * (1.0 - mesh.a)));
}

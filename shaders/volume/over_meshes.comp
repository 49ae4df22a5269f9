// SPDX-License-Identifier: Apache-2.0
// reads the picture of the meshes, and how the medium changes it: L_medium - (1 - T) L_mesh; writes
// their sum, the picture. Where the medium is not in the way it is that of the meshes, bit for bit.
#version 460
#extension GL_GOOGLE_include_directive : require

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0, rgba32f) uniform readonly image2D meshes;
layout(binding = 1, rgba32f) uniform readonly image2D change;
layout(binding = 2, rgba32f) uniform writeonly image2D picture;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(picture)))) return;
    vec4 sum = imageLoad(meshes, pixel) + imageLoad(change, pixel);
    imageStore(picture, pixel, sum);
}

// SPDX-License-Identifier: Apache-2.0
// What one picture is made with: camera, size, background, sample order. Written by the program
// once per frame.
#ifndef OCKHAM_SHADERS_SHARED_FRAME_H
#define OCKHAM_SHADERS_SHARED_FRAME_H

#include "shared/types.h"

OCKHAM_SHARED_BEGIN

#define MAX_WINDOW 8       // m: window width in samples
#define MAX_SAMPLES 64     // n = m * m

struct FrameData {
    mat4 view_projection; ///< world to clip, reversed depth: 1 at the near plane, 0 at infinity
    mat4 sun_projection;  ///< world to shadow map: xy in [-1,1], z in [0,1], 1 nearest to the sun
    vec3 position;        ///< camera, world
    float near_distance;  ///< perspective: view depth = near / stored depth
    vec3 right;           ///< half the picture's width at view depth 1 (orthographic: in world units)
    float far_distance;   ///< orthographic: view depth = far * (1 - stored depth)
    vec3 up;              ///< half the picture's height, likewise
    float background_depth; ///< view depth that the paper's metric sees where no surface is hit
    vec3 forward;
    uint orthographic;
    vec3 background; ///< radiance
    float sun_texel; ///< world size of a shadow map texel
    vec3 ambient;    ///< radiance
    uint m;          ///< window width in samples
    uvec2 size;      ///< of the images, pixels: the picture, or a screen tile of it
    ivec2 origin;    ///< the images' first pixel in the picture
    uvec2 picture;   ///< in pixels
    vec2 jitter;     ///< where samples are taken, in samples from their centres to the right and down
    uint directional_count;
    uint point_count;
    uint spot_count;
    uint order[MAX_SAMPLES]; ///< i-th sample taken -> index in the window, row-major
};

OCKHAM_SHARED_END

#endif

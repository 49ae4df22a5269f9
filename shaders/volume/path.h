// SPDX-License-Identifier: Apache-2.0
// A path of light between two iterations: all that its next one needs. Kernels store it where their
// budget of iterations ends and go on with it in the next dispatch.
#ifndef OCKHAM_SHADERS_VOLUME_PATH_H
#define OCKHAM_SHADERS_VOLUME_PATH_H

#include "shared/types.h"

OCKHAM_SHARED_BEGIN

// Stages. A path that has ended holds its estimate in radiance; zeroed memory says so too.
#define PATH_ENDED 0u
#define PATH_FLIGHT 1u  // looks for the next collision
#define PATH_SCATTER 2u // is about to leave a collision in the medium
#define PATH_CAMERA 3u  // is about to leave the camera
#define PATH_SHADOW 4u  // with FLIGHT or SCATTER, before it: how much light arrives at the collision
#define PATH_MEETING 8u // with MEETS_* of volume/path.glsl: what ends the flight is known, but for meshes

struct Path {
    vec3 radiance;       ///< estimate so far
    vec3 throughput;     ///< of the flight; 0: the path ends with its shadow ray
    vec3 origin;         ///< world, of the flight and of the shadow ray; PATH_CAMERA: the pixel
    vec3 direction;      ///< of the flight
    vec3 pending;        ///< what the light adds at the origin where nothing stands between
    vec3 to_light;       ///< direction of the shadow ray
    float transmittance; ///< of the shadow ray up to t
    float t;             ///< how far the ray has come; < 0: it has not begun
    float depth;         ///< optical depth, under the majorants, to the next tentative collision
    float chance;        ///< uniform: that one is real for a flight where it is more likely
    float pdf;           ///< of the direction, per steradian; < 0: no sampled light competes with it.
                         ///< Among meshes, where none does, the length of the shadow ray
    float search;        ///< up to where no surface is; < 0: the ray may begin in a solid
    uint cell;           ///< that t lies in, packed
    uint stage;          ///< PATH_*
    uint bounces;        ///< scatterings so far
    uvec4 random;        ///< seed, stream, sample, next set of what has no fixed place
};
OCKHAM_SHARED_SIZE(Path, 124);

OCKHAM_SHARED_END

#endif

// SPDX-License-Identifier: Apache-2.0
// Parameters of subpixel reconstruction.
#ifndef OCKHAM_SHADERS_SURFACE_SRAA_H
#define OCKHAM_SHADERS_SURFACE_SRAA_H

#include "shared/types.h"

OCKHAM_SHARED_BEGIN

struct SraaPush {
    float radius;       ///< standard deviation of the weight over the picture, pixels
    float plane_error;  ///< of the distance from the sample's plane, pixels at its depth
    float normal_power; ///< of the cosine between the normals
};

OCKHAM_SHARED_END

#endif

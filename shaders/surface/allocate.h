// SPDX-License-Identifier: Apache-2.0
// Parameters of the allocation of samples from an image of variances.
#ifndef OCKHAM_SHADERS_SURFACE_ALLOCATE_H
#define OCKHAM_SHADERS_SURFACE_ALLOCATE_H

#include "shared/types.h"

OCKHAM_SHARED_BEGIN

struct AllocatePush {
    uvec2 size;    ///< pixels
    uint samples;  ///< n
    float lambda;  ///< variance that the last sample of a pixel must remove
};

OCKHAM_SHARED_END

#endif

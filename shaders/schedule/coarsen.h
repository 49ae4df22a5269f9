// SPDX-License-Identifier: Apache-2.0
// Parameters of the coarsening of sample counts.
#ifndef OCKHAM_SHADERS_SCHEDULE_COARSEN_H
#define OCKHAM_SHADERS_SCHEDULE_COARSEN_H

#include "shared/types.h"

OCKHAM_SHARED_BEGIN

struct CoarsenPush {
    uvec2 size;          ///< picture in pixels
    uint block;          ///< pixels per block and axis that share the largest count; 1: none
    uint powers_of_two;  ///< 1: counts are rounded up to powers of two, n stays
    uint n;              ///< samples of a window, the largest count
};

OCKHAM_SHARED_END

#endif

// SPDX-License-Identifier: Apache-2.0
// Size of the volume, in voxels and in cells of RANGE_CELL^3 voxels.
#ifndef OCKHAM_SHADERS_VOLUME_RANGES_H
#define OCKHAM_SHADERS_VOLUME_RANGES_H

#include "shared/types.h"

OCKHAM_SHARED_BEGIN

struct RangesPush {
    uvec3 dims;
    uvec3 cells; ///< dims / RANGE_CELL, rounded up
};

OCKHAM_SHARED_END

#endif

// SPDX-License-Identifier: Apache-2.0
// Push constants of shaders/volume/reach.comp.
#ifndef OCKHAM_SHADERS_VOLUME_REACH_H
#define OCKHAM_SHADERS_VOLUME_REACH_H

#include "shared/types.h"

OCKHAM_SHARED_BEGIN

struct ReachPush {
    uvec3 cells;
    uint axis; ///< 0, 1, 2: in this order
};

OCKHAM_SHARED_END

#endif

// SPDX-License-Identifier: Apache-2.0
// Parameters of the composition of a volume along view rays.
#ifndef OCKHAM_SHADERS_VOLUME_COMPOSE_H
#define OCKHAM_SHADERS_VOLUME_COMPOSE_H

#include "shared/types.h"

OCKHAM_SHARED_BEGIN

struct ComposePush {
    uint iterations;   ///< loop budget of an invocation
    uint jitter;       ///< 0: rays through pixel centres, samples in the middle of their steps
    float step_voxels; ///< longest step
    float step_depth;  ///< optical depth that a step shall not exceed
    uint begins;       ///< 0: only rays under way go on
};
OCKHAM_SHARED_SIZE(ComposePush, 20);

OCKHAM_SHARED_END

#endif

// SPDX-License-Identifier: Apache-2.0
// Parameters of the resolve.
#ifndef OCKHAM_SHADERS_SURFACE_RESOLVE_H
#define OCKHAM_SHADERS_SURFACE_RESOLVE_H

#include "shared/types.h"

OCKHAM_SHARED_BEGIN

struct ResolvePush {
    uvec2 size; ///< picture in pixels
    uint count; ///< k where it is the same everywhere
};

OCKHAM_SHARED_END

#endif

// SPDX-License-Identifier: Apache-2.0
// How much one execution of surface_depth.comp searches.
#ifndef OCKHAM_SHADERS_VOLUME_SURFACE_DEPTH_H
#define OCKHAM_SHADERS_VOLUME_SURFACE_DEPTH_H

#include "shared/types.h"

OCKHAM_SHARED_BEGIN

struct SurfaceDepthPush {
    uint steps; ///< stochastic: candidates of each pixel; march: samples along each ray
};

OCKHAM_SHARED_END

#endif

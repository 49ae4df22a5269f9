// SPDX-License-Identifier: Apache-2.0
// Parameters of cluster_counts.
#ifndef OCKHAM_SHADERS_SURFACE_CLUSTER_COUNTS_H
#define OCKHAM_SHADERS_SURFACE_CLUSTER_COUNTS_H

#include "shared/types.h"

OCKHAM_SHARED_BEGIN

struct ClusterCountsPush {
    uint samples; ///< n
    uint single;  ///< k of a pixel with one surface
    uint several; ///< k of the others; 0: one for each surface
};

OCKHAM_SHARED_END

#endif

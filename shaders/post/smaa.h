// SPDX-License-Identifier: Apache-2.0
// What the three kernels of SMAA share: edges of a pixel as bits, and how far ends are looked for.
#ifndef OCKHAM_SHADERS_POST_SMAA_H
#define OCKHAM_SHADERS_POST_SMAA_H

#include "shared/types.h"

OCKHAM_SHARED_BEGIN

#define SMAA_EDGE_LEFT 1u // between the pixel and the one to its left
#define SMAA_EDGE_TOP 2u  // and the one above
#define SMAA_REACH 32     // pixels searched along an edge, to each side

struct SmaaPush {
    float threshold; ///< luma steps from here on are edges
};

OCKHAM_SHARED_END

#endif

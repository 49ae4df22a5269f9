// SPDX-License-Identifier: Apache-2.0
// What the three kernels of SMAA share: edges of a pixel as bits, and how far ends are looked for.
#ifndef OCKHAM_SHADERS_POST_SMAA_H
#define OCKHAM_SHADERS_POST_SMAA_H

#include "shared/types.h"

OCKHAM_SHARED_BEGIN

#define SMAA_EDGE_LEFT 1u // between the pixel and the one to its left
#define SMAA_EDGE_TOP 2u  // and the one above
#define SMAA_REACH 32     // pixels searched along an edge, to each side
#define SMAA_DIAGONAL_REACH 16 // steps searched along a diagonal, to each side
#define SMAA_CORNER 0.25f // of what a corner would lose, this much it does

struct SmaaPush {
    float threshold; ///< luma steps from here on are edges
};

OCKHAM_SHARED_END

#endif

// SPDX-License-Identifier: Apache-2.0
// Parameters of one axis of the bloom.
#ifndef OCKHAM_SHADERS_POST_BLOOM_H
#define OCKHAM_SHADERS_POST_BLOOM_H

#include "shared/types.h"

OCKHAM_SHARED_BEGIN

struct BloomPush {
    ivec2 axis;  ///< (1, 0): along rows; (0, 1): along columns
    int radius;  ///< pixels to each side
    float sigma; ///< pixels
    float share; ///< of the blurred picture in what is written, 0 ... 1
};

OCKHAM_SHARED_END

#endif

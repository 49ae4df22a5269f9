// SPDX-License-Identifier: Apache-2.0
// Parameters of FXAA.
#ifndef OCKHAM_SHADERS_POST_FXAA_H
#define OCKHAM_SHADERS_POST_FXAA_H

#include "shared/types.h"

OCKHAM_SHARED_BEGIN

struct FxaaPush {
    float subpixel;      ///< how much of what is narrower than a pixel is blurred away, 0 ... 1
    float threshold;     ///< luma ranges below this share of the brightest are no edge
    float threshold_min; ///< nor are ranges below this
};

OCKHAM_SHARED_END

#endif

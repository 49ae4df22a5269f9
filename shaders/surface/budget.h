// SPDX-License-Identifier: Apache-2.0
// The budget's buffers and parameters.
#ifndef OCKHAM_SHADERS_SURFACE_BUDGET_H
#define OCKHAM_SHADERS_SURFACE_BUDGET_H

#include "shared/types.h"

OCKHAM_SHARED_BEGIN

#define BUDGET_BINS 2048      // of values, 16 an octave
#define BUDGET_SCAN_WIDTH 256 // divides BUDGET_BINS

/// Which pixels have variance in a bin.
struct BudgetBin {
    uint within;  ///< pixels with this w^2
    int surfaces; ///< change of the samples that surfaces add as lambda falls below this bin
};

/// The price: samples worth the bin's value are all taken, of those worth the next lower one only
/// so many, the first ones in the picture.
struct BudgetPrice {
    uint bin;
    uint left;
};

struct BudgetPush {
    uvec2 size;   ///< pixels
    uint samples; ///< n
    uint target;  ///< samples to spend in all, at least one a pixel
    uint run;     ///< pixels, in row-major order, that one invocation walks over
};

OCKHAM_SHARED_END

#endif

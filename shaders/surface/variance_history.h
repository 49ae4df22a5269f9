// SPDX-License-Identifier: Apache-2.0
// Parameters of variance_history.comp.
#ifndef OCKHAM_SHADERS_SURFACE_VARIANCE_HISTORY_H
#define OCKHAM_SHADERS_SURFACE_VARIANCE_HISTORY_H

#include "shared/types.h"

OCKHAM_SHARED_BEGIN

struct VarianceHistoryPush {
    float keep; ///< share of a fall that is kept back for a frame, [0, 1)
};

OCKHAM_SHARED_END

#endif

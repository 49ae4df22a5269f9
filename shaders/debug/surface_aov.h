// SPDX-License-Identifier: Apache-2.0
// Parameters of surface_aov.
#ifndef OCKHAM_SHADERS_DEBUG_SURFACE_AOV_H
#define OCKHAM_SHADERS_DEBUG_SURFACE_AOV_H

#include "shared/types.h"

OCKHAM_SHARED_BEGIN

#define NO_MATERIAL 0xffffffu // the largest 24-bit number: background

OCKHAM_SHARED_END

#endif

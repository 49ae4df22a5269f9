// SPDX-License-Identifier: Apache-2.0
// What the path tracer of pixels is told, and what it counts.
#ifndef OCKHAM_SHADERS_VOLUME_PATH_TRACE_H
#define OCKHAM_SHADERS_VOLUME_PATH_TRACE_H

#include "shared/types.h"

OCKHAM_SHARED_BEGIN

struct PathTracePush {
    uint first_row;  ///< of the picture: paths begin there
    uint rows;
    uint samples;    ///< that each pixel is to take beyond those it was told before
    uint iterations; ///< budget of an invocation, >= 1
    uint jitter;     ///< 1: positions in the pixel's square; 0: its centre
    uint nee;        ///< 1: the environment map is sampled at collisions
};

// Statistics: 64-bit sums, low word first, since the last restart.
#define PATHS_WANTED 0    // samples that pixels were told to take
#define PATHS_FINISHED 1  // all of those, once nothing is left to resume
#define PATHS_STEPS 2     // tentative collisions: lookups of the field
#define PATHS_RESUMED 3   // paths stored because a budget was used up
#define PATHS_TRUNCATED 4 // paths dropped because their value was not finite: must be 0
#define PATHS_CLAMPED 5   // extinctions above their majorant: must be 0
#define PATHS_STATISTICS 6

OCKHAM_SHARED_END

#endif

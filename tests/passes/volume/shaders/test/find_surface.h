// SPDX-License-Identifier: Apache-2.0
// What the test of find_surface() sends and gets.
#ifndef OCKHAM_TEST_FIND_SURFACE_H
#define OCKHAM_TEST_FIND_SURFACE_H

#include "shared/types.h"

OCKHAM_SHARED_BEGIN

struct FindSurfaceRay {
    vec3 origin; ///< world
    float t0;
    vec3 direction; ///< unit
    float t1;
    vec3 entry_normal;
    uint start_solid;
};
struct FindSurfaceHit {
    float t;
    uint surface;
    vec3 normal;
    uint cut;
    uint found;
    uint calls;
};
struct FindSurfacePush {
    uint count;
    uint budget; ///< of each call
};

OCKHAM_SHARED_END

#endif

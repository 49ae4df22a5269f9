// SPDX-License-Identifier: Apache-2.0
// What the probe finds in one sample of a G-buffer.
#ifndef OCKHAM_TESTS_SURFACE_PROBE_H
#define OCKHAM_TESTS_SURFACE_PROBE_H

#include "shared/types.h"

OCKHAM_SHARED_BEGIN

struct SurfaceProbe {
    float depth; ///< stored; 0: background, the rest is undefined
    uint material;
    vec3 normal;
    vec3 color;
    vec2 uv[2];
    vec2 gradient_x[2];
    vec2 gradient_y[2];
    vec2 slope;
    vec3 plane_normal;
    uint breaks; ///< bit 0: discontinuous one sample to the right; bit 1: one down
};

OCKHAM_SHARED_END

#endif

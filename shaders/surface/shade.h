// SPDX-License-Identifier: Apache-2.0
// Parameters of the shading kernels: first_sample and shade.
#ifndef OCKHAM_SHADERS_SURFACE_SHADE_H
#define OCKHAM_SHADERS_SURFACE_SHADE_H

#include "shared/types.h"

OCKHAM_SHARED_BEGIN

struct ShadePush {
    uint count;   ///< k, samples per pixel, where no map gives it; of a list: which range
    uint first;   ///< this dispatch sums the samples first ... last-1 of each pixel
    uint last;
    uint stall;   ///< dependent FMAs per shaded sample, rounded up to whole iterations of 16
    float anisotropy; ///< most texture taps per lookup
    uint loop_bound;  ///< most shaded samples per invocation: the host proves it suffices
};

struct SurfaceMeansPush {
    float anisotropy; ///< as above
};

// Specialisation: light types that the scene has.
#define SPEC_DIRECTIONAL_LIGHTS 0
#define SPEC_POINT_LIGHTS 1
#define SPEC_SPOT_LIGHTS 2
// What samples that stand for others take from all of their surface.
#define SPEC_DEMODULATE 3
#define SPEC_FILTER_HIGHLIGHTS 4
// More than a uniform buffer is made for.
#define SPEC_MANY_LIGHTS 5
#define SPEC_MANY_MATERIALS 6

OCKHAM_SHARED_END

#endif

// SPDX-License-Identifier: Apache-2.0
// What the test of iso_bsdf.glsl sends and gets.
#ifndef OCKHAM_TEST_ISO_BSDF_H
#define OCKHAM_TEST_ISO_BSDF_H

#include "shared/types.h"

OCKHAM_SHARED_BEGIN

struct IsoBsdfAnswer {
    vec3 direction;
    vec3 value;      ///< evaluated: BRDF * cos; sampled: that over pdf
    vec3 again;      ///< BRDF * cos; with view and direction exchanged where `value` is that
    float pdf;       ///< as evaluated, or as sampling says
    float pdf_again; ///< of pdf_iso() for the same direction
};
struct IsoBsdfPush {
    vec3 normal;
    vec3 view;
    uint shading;
    uint material;
    uint mode;
    uint count;
};

OCKHAM_SHARED_END

#endif

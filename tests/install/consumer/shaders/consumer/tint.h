// SPDX-License-Identifier: Apache-2.0
// Push constants of consumer/tint.comp, for C++ and GLSL.
#ifndef CONSUMER_TINT_H
#define CONSUMER_TINT_H
#include "shared/types.h"

OCKHAM_SHARED_BEGIN
struct Tint {
    vec3 color; ///< multiplies the picture
    float alpha;
};
OCKHAM_SHARED_SIZE(Tint, 16);
OCKHAM_SHARED_END

#endif

// SPDX-License-Identifier: Apache-2.0
// Constants of the G-buffer's raster pass.
#ifndef OCKHAM_SHADERS_SURFACE_GBUFFER_H
#define OCKHAM_SHADERS_SURFACE_GBUFFER_H

#include "shared/types.h"

OCKHAM_SHARED_BEGIN

struct DrawPush {
    uint material;
};

// Specialisation: floats from one vertex to the next, and where in it each attribute starts
// (ATTRIBUTE_ABSENT: the scene has none).
#define SPEC_VERTEX_STRIDE 0
#define SPEC_NORMAL_OFFSET 1
#define SPEC_TANGENT_OFFSET 2
#define SPEC_UV0_OFFSET 3
#define SPEC_UV1_OFFSET 4
#define SPEC_COLOR_OFFSET 5
#define ATTRIBUTE_ABSENT 0xffffffffu

OCKHAM_SHARED_END

#endif

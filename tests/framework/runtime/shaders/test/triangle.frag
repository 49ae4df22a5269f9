// SPDX-License-Identifier: Apache-2.0
// Writes: id, the pushed number, and coverage 1.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.h"

layout(push_constant, scalar) uniform Push { uint id; } push;
layout(location = 0) out uint id;
layout(location = 1) out float coverage;

void main() {
    id = push.id;
    coverage = 1.0;
}

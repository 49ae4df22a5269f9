// SPDX-License-Identifier: Apache-2.0
// What a medium lets through of a light on its way to a surface: MEDIUM. Without one everything,
// which costs nothing.

#ifdef MEDIUM
#define GRID
#define SURFACES
#define MEDIUM_BINDING 26
#include "volume/transmittance.glsl"

/// Transmittance from a point with normal `n` to a light in direction `l`, `distance` away; none
/// where that lies behind the point.
float lit_through(vec3 world, vec3 n, vec3 l, float distance) {
    return dot(n, l) > 0.0 ? transmittance(world, l, distance) : 0.0;
}
#else
float lit_through(vec3 world, vec3 n, vec3 l, float distance) { return 1.0; }
#endif

// SPDX-License-Identifier: Apache-2.0
// What a medium lets through of a light on its way to a surface: MEDIUM. Without one everything,
// which costs nothing.

#ifdef MEDIUM
#define GRID
#define SURFACES
#define MEDIUM_BINDING 26
#include "volume/transmittance.glsl"

/// Transmittance from a point with normal `n` to a light in direction `l`, `distance` away; none
/// where that lies behind the point. `iso`: the point is on an isosurface.
float lit_through(vec3 world, vec3 n, vec3 l, float distance, bool iso) {
    vec3 beside = iso ? off_surface(world, n, l) : world;
    return dot(n, l) > 0.0 ? transmittance(world, beside, l, distance, !iso) : 0.0;
}
#else
float lit_through(vec3 world, vec3 n, vec3 l, float distance, bool iso) { return 1.0; }
#endif

// SPDX-License-Identifier: Apache-2.0
// Materials, and texture coordinates moved and wrapped as a material asks.
#ifndef OCKHAM_SHADERS_SURFACE_MATERIAL_GLSL
#define OCKHAM_SHADERS_SURFACE_MATERIAL_GLSL

#include "shared/scene.h"

struct TextureCoordinates {
    vec2 uv;         // wrapped
    vec2 gradient_x; // per sample to the right
    vec2 gradient_y; // per sample down
};

/// Derivatives of the vertices' coordinates, of either set.
struct UvDerivatives {
    vec2 x0, x1, y0, y1;
};

vec2 map_uv(UvMap map, vec2 uv0, vec2 uv1) {
    vec3 uv = vec3(map.set == 0u ? uv0 : uv1, 1.0);
    return vec2(dot(map.u, uv), dot(map.v, uv));
}

/// The same for a change of coordinates. Derivatives are taken before the map, not after: drivers
/// may give helper invocations zeros for what is read from buffers, the map among them.
vec2 map_uv_change(UvMap map, vec2 uv0, vec2 uv1) {
    vec2 change = map.set == 0u ? uv0 : uv1;
    return vec2(dot(map.u.xy, change), dot(map.v.xy, change));
}

/// Wrap modes on top of a repeating sampler: clamped and mirrored coordinates are folded into
/// [0,1], half a texel inside, so that a filter at the border does not meet the other side.
float wrap_coordinate(float x, uint mode, float inset) {
    if (mode == 1u) return clamp(x, inset, 1.0 - inset);
    if (mode == 2u) {
        float t = abs(x - 2.0 * floor(0.5 * x) - 1.0);
        return clamp(1.0 - t, inset, 1.0 - inset);
    }
    return x;
}

vec2 wrap_uv(UvMap map, vec2 uv) {
    return vec2(wrap_coordinate(uv.x, map.wrap & 3u, map.inset.x),
        wrap_coordinate(uv.y, map.wrap >> 2, map.inset.y));
}

/// -1 where a mirrored tile runs against the coordinates, else 1.
float wrap_sign(float x, uint mode) {
    return mode == 2u && mod(floor(x), 2.0) != 0.0 ? -1.0 : 1.0;
}

vec2 wrap_direction(UvMap map, vec2 uv) {
    return vec2(wrap_sign(uv.x, map.wrap & 3u), wrap_sign(uv.y, map.wrap >> 2));
}

TextureCoordinates map_coordinates(UvMap map, vec2 uv0, vec2 uv1, UvDerivatives d) {
    TextureCoordinates c;
    vec2 uv = map_uv(map, uv0, uv1);
    vec2 direction = wrap_direction(map, uv);
    c.gradient_x = map_uv_change(map, d.x0, d.x1) * direction;
    c.gradient_y = map_uv_change(map, d.y0, d.y1) * direction;
    c.uv = wrap_uv(map, uv);
    return c;
}

/// The normal tilted by a texel of a normal map, both ends unit. `tangent`: its handedness in w; 0
/// leaves the normal as it is.
vec3 bump_normal(vec3 normal, vec4 tangent, vec3 texel, float scale) {
    vec3 t = (2.0 * texel - 1.0) * vec3(scale, scale, 1.0);
    vec3 along = tangent.xyz - normal * dot(normal, tangent.xyz);
    float along_length = length(along);
    if (along_length > 0.0) {
        along /= along_length;
        vec3 across = cross(normal, along) * tangent.w;
        normal = normalize(t.x * along + t.y * across + t.z * normal);
    }
    return normal;
}

#endif

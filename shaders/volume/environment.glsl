// SPDX-License-Identifier: Apache-2.0
// Light from far away, all around: one radiance, or a map.
//   reads environment, environment_table (ENVIRONMENT_MAP)
//   pdf(w) = luminance(w) / integral of luminance, per steradian
// The map is constant over each texel, so that sampling by luminance x solid angle is exact. Rows
// divide the angle from +z, which is up for volumes, evenly; columns turn about z, +y, where the
// default camera looks, in the middle and +x to its right.
#ifndef OCKHAM_VOLUME_ENVIRONMENT_GLSL
#define OCKHAM_VOLUME_ENVIRONMENT_GLSL

#include "include/color.glsl"
#include "volume/medium.glsl"

#ifdef ENVIRONMENT_MAP

layout(binding = 6) uniform sampler2D environment;
layout(scalar, binding = 7) readonly buffer EnvironmentTable {
    float pdf_scale; // density = scale * luminance + offset: 1 / integral and 0, but of a black map
    float pdf_offset;
    // Of a map of w x h texels:
    //   h + 1 squares of sin(angle / 2), of the angles from +z where rows begin and end
    //   h probabilities of a row above the end of each row
    //   h x w probabilities, given the row, of a texel left of the end of each texel
    float items[];
} environment_table;

uvec2 environment_texel(vec3 direction) {
    const float kPi = 3.14159265;
    // Both by atan(): acos() is good to three digits on some drivers.
    vec2 place = vec2(0.5 + atan(direction.x, direction.y) / (2.0 * kPi),
        atan(length(direction.xy), direction.z) / kPi);
    uvec2 size = constants.environment_size;
    return min(uvec2(place * vec2(size)), size - 1u);
}

vec3 environment_radiance(vec3 direction) {
    return texelFetch(environment, ivec2(environment_texel(direction)), 0).xyz;
}

/// Per steradian, where this is the radiance.
float environment_pdf_of(vec3 radiance) {
    return environment_table.pdf_scale * luminance(radiance) +
           environment_table.pdf_offset;
}
float environment_pdf(vec3 direction) {
    return environment_pdf_of(environment_radiance(direction));
}

/// First of `count` rising numbers that is greater than xi, which the last one is; count <= 2^14.
/// Fourteen steps for any count, unrolled: loops are counted by some drivers.
uint first_beyond(uint begin, uint count, float xi) {
    uint below = 0u; // how many are known not to be greater
#define STEP(size) \
    if (below + size < count && environment_table.items[begin + below + size - 1u] <= xi) \
        below += size;
    STEP(8192u) STEP(4096u) STEP(2048u) STEP(1024u) STEP(512u) STEP(256u) STEP(128u)
    STEP(64u) STEP(32u) STEP(16u) STEP(8u) STEP(4u) STEP(2u) STEP(1u)
#undef STEP
    return below;
}

/// Where xi lies in the interval of such a list that holds it: uniform again, in [0, 1).
float rest_of(uint begin, uint entry, float xi) {
    float low = entry == 0u ? 0.0 : environment_table.items[begin + entry - 1u];
    return (xi - low) / (environment_table.items[begin + entry] - low);
}

/// Radiance from a direction that is drawn with density `pdf`; `xi` in (0, 1).
vec3 sample_environment(vec2 xi, out vec3 direction, out float pdf) {
    uvec2 size = constants.environment_size;
    uint rows = size.y + 1u;
    uint row = first_beyond(rows, size.y, xi.y);
    uint columns = rows + size.y + row * size.x;
    uint column = first_beyond(columns, size.x, xi.x);
    // Even in the cosine, c - s, by the squares s and c of sine and cosine of half the angle: they
    // are precise at their pole each, and the list is both, upwards and downwards.
    float down = rest_of(rows, row, xi.y);
    float s = mix(environment_table.items[row], environment_table.items[row + 1u], down);
    float c = mix(environment_table.items[size.y - row],
        environment_table.items[size.y - row - 1u], down);
    float across = (float(column) + rest_of(columns, column, xi.x)) / float(size.x);
    float azimuth = (across - 0.5) * 6.28318531;
    float sine = 2.0 * sqrt(s * c);
    direction = normalize(vec3(sine * sin(azimuth), sine * cos(azimuth), c - s));
    vec3 radiance = texelFetch(environment, ivec2(column, row), 0).xyz;
    pdf = environment_pdf_of(radiance);
    return radiance;
}

#else

vec3 environment_radiance(vec3 direction) { return constants.environment; }

#endif

#endif

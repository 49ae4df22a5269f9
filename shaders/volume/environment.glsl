// SPDX-License-Identifier: Apache-2.0
// Light from far away, all around: one radiance, or a map.
//   reads environment, environment_table (ENVIRONMENT_MAP)
//   pdf(w) = luminance(w) / integral of luminance, per steradian
// The map is constant over each texel, so that sampling by luminance x solid angle is exact. Rows
// divide the angle from +y evenly; columns turn about y, -z in the middle, +x to its right.
#ifndef OCKHAM_VOLUME_ENVIRONMENT_GLSL
#define OCKHAM_VOLUME_ENVIRONMENT_GLSL

#include "volume/medium.glsl"

#ifdef ENVIRONMENT_MAP

layout(binding = 6) uniform sampler2D environment;
/// Probability that a row is above the end of each row: height numbers; then, for each row, that a
/// texel of it is left of the end of each texel: height x width.
layout(scalar, binding = 7) readonly buffer EnvironmentTable { float ends[]; } environment_table;

uvec2 environment_texel(vec3 direction) {
    const float kPi = 3.14159265;
    // Both by atan(): acos() is good to three digits on some drivers.
    vec2 place = vec2(0.5 + atan(direction.x, -direction.z) / (2.0 * kPi),
        atan(length(direction.xz), direction.y) / kPi);
    uvec2 size = frame.data.environment_size;
    return min(uvec2(place * vec2(size)), size - 1u);
}

vec3 environment_radiance(vec3 direction) {
    return texelFetch(environment, ivec2(environment_texel(direction)), 0).xyz;
}

/// First of `count` rising numbers that is greater than xi, which the last one is; count <= 2^14.
/// Fourteen steps for any count, unrolled: loops are counted by some drivers.
uint first_beyond(uint begin, uint count, float xi) {
    uint below = 0u; // how many are known not to be greater
#define STEP(size) \
    if (below + size < count && environment_table.ends[begin + below + size - 1u] <= xi) \
        below += size;
    STEP(8192u) STEP(4096u) STEP(2048u) STEP(1024u) STEP(512u) STEP(256u) STEP(128u)
    STEP(64u) STEP(32u) STEP(16u) STEP(8u) STEP(4u) STEP(2u) STEP(1u)
#undef STEP
    return below;
}

/// Share of [0, 1) that belongs to an entry of such a list.
vec2 interval(uint begin, uint entry) {
    float end = environment_table.ends[begin + entry];
    return vec2(entry == 0u ? 0.0 : environment_table.ends[begin + entry - 1u], end);
}

/// Cosines of the angles from +y between which a row lies: upper, lower.
vec2 row_cosines(uint row) {
    return cos((vec2(row) + vec2(0.0, 1.0)) * (3.14159265 / float(frame.data.environment_size.y)));
}

/// Density of the texel per steradian.
float texel_pdf(uvec2 texel) {
    uvec2 size = frame.data.environment_size;
    vec2 rows = interval(0u, texel.y), columns = interval(size.y + texel.y * size.x, texel.x);
    vec2 cosines = row_cosines(texel.y);
    float solid_angle = (cosines.x - cosines.y) * 6.28318531 / float(size.x);
    return (rows.y - rows.x) * (columns.y - columns.x) / solid_angle;
}

/// Per steradian.
float environment_pdf(vec3 direction) { return texel_pdf(environment_texel(direction)); }

/// Radiance from a direction that is drawn with density `pdf`; `xi` in (0, 1).
vec3 sample_environment(vec2 xi, out vec3 direction, out float pdf) {
    uvec2 size = frame.data.environment_size;
    uint row = first_beyond(0u, size.y, xi.y);
    uint columns = size.y + row * size.x;
    uint column = first_beyond(columns, size.x, xi.x);
    // What choosing left over of the numbers is uniform again.
    vec2 y = interval(0u, row), x = interval(columns, column);
    float across = (float(column) + (xi.x - x.x) / (x.y - x.x)) / float(size.x);
    vec2 cosines = row_cosines(row);
    float cosine = mix(cosines.x, cosines.y, (xi.y - y.x) / (y.y - y.x));
    float azimuth = (across - 0.5) * 6.28318531;
    float sine = sqrt(max(1.0 - cosine * cosine, 0.0));
    direction = vec3(sine * sin(azimuth), cosine, -sine * cos(azimuth));
    pdf = texel_pdf(uvec2(column, row));
    return texelFetch(environment, ivec2(column, row), 0).xyz;
}

#else

vec3 environment_radiance(vec3 direction) { return frame.data.environment; }

#endif

#endif

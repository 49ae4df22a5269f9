// SPDX-License-Identifier: Apache-2.0
// What a map of distances from the sun (passes/surface/shadow_map.hpp) says about a point.

/// Share of the four nearest texels that the sun reaches at least as far as `p`, interpolated. `p`:
/// in the map's clip space; depths are 1 nearest to the sun. The map holds all meshes: beside it none
/// stands in the way, behind it all do.
float sun_map_share(sampler2D map, vec3 p) {
    bool beside = any(greaterThan(abs(p.xy), vec2(1.0)));
    p.z = max(p.z, 0.0);
    vec2 size = vec2(textureSize(map, 0));
    vec2 texel = (0.5 * p.xy + 0.5) * size - 0.5;
    vec2 base = floor(texel);
    vec2 weight = texel - base;
    vec4 nearest = textureGather(map, (base + 1.0) / size); // beyond a border the last texels
    float lit00 = float(p.z >= nearest.w);
    float lit10 = float(p.z >= nearest.z);
    float lit01 = float(p.z >= nearest.x);
    float lit11 = float(p.z >= nearest.y);
    float share = mix(mix(lit00, lit10, weight.x), mix(lit01, lit11, weight.x), weight.y);
    return beside ? 1.0 : share;
}

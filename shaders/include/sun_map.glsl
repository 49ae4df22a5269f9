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
    ivec2 base = ivec2(floor(texel));
    vec2 weight = texel - vec2(base);
    ivec2 limit = ivec2(size) - 1;
    ivec2 low = clamp(base, ivec2(0), limit);
    ivec2 high = clamp(base + 1, ivec2(0), limit);
    float lit00 = float(p.z >= texelFetch(map, low, 0).x);
    float lit10 = float(p.z >= texelFetch(map, ivec2(high.x, low.y), 0).x);
    float lit01 = float(p.z >= texelFetch(map, ivec2(low.x, high.y), 0).x);
    float lit11 = float(p.z >= texelFetch(map, high, 0).x);
    float share = mix(mix(lit00, lit10, weight.x), mix(lit01, lit11, weight.x), weight.y);
    return beside ? 1.0 : share;
}

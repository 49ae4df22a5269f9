// SPDX-License-Identifier: Apache-2.0
// Isosurfaces along a ray, exact: the first point where the trilinear field crosses an isovalue.
// Cells of ranges that no isovalue lies in are skipped; in the cells between eight voxel centres the
// field along the ray is a cubic, kept in Bernstein form (its control values are its blossom), cut
// at its extrema, and bisected. Needs SURFACES; docs/passes/surface_depth.md.
// After Parker et al. 1998 and Marmitt et al. 2004.
#ifndef OCKHAM_VOLUME_SURFACE_GLSL
#define OCKHAM_VOLUME_SURFACE_GLSL

#extension GL_EXT_control_flow_attributes : require

#include "volume/cells.glsl"

const uint kNoSurface = ~0u;

struct SurfaceHit {
    float t;      // along the ray, in world units
    uint surface; // index of frame.surfaces
    vec3 normal;  // unit, world, towards lower values, whichever side the ray comes from
    bool cut;     // the ray starts in the solid: the normal is that of the plane which cuts it
};

/// World units from a hit to where the same crossing is not met again: a hundredth of a voxel.
float beyond_hit() {
    vec3 voxel = vec3(length(constants.world_from_unit[0]), length(constants.world_from_unit[1]),
                     length(constants.world_from_unit[2])) / vec3(constants.dims);
    return 0.01 * min(min(voxel.x, voxel.y), voxel.z);
}

/// Unused ones are never reached.
vec4 isovalues() {
    vec4 values = vec4(kInfinity);
    uint count = constants.surface_count;
    if (count > 0u) values.x = constants.surfaces[0].value;
    if (count > 1u) values.y = constants.surfaces[1].value;
    if (count > 2u) values.z = constants.surfaces[2].value;
    if (count > 3u) values.w = constants.surfaces[3].value;
    return values;
}
float least(vec4 v) { return min(min(v.x, v.y), min(v.z, v.w)); }
float greatest(vec4 v) { return max(max(v.x, v.y), max(v.z, v.w)); }
uint surface_of(vec4 values, float value) {
    return value == values.x ? 0u : value == values.y ? 1u : value == values.z ? 2u : 3u;
}

/// Every value from low to high is on the same side of every isovalue. On it is inside.
bool on_one_side(vec4 values, float low, float high) {
    return all(equal(lessThanEqual(values, vec4(low)), lessThanEqual(values, vec4(high))));
}
/// The isovalue that a monotone change between two values crosses first; kInfinity: none.
float first_crossed(vec4 values, float from, float to) {
    bvec4 was = lessThanEqual(values, vec4(from)), is = lessThanEqual(values, vec4(to));
    if (was == is) return kInfinity;
    return from < to ? least(mix(values, vec4(kInfinity), was))
                     : greatest(mix(vec4(-kInfinity), values, was));
}
/// The surface whose inside this is: of nested ones the innermost. kNoSurface: outside of all.
uint surface_around(vec4 values, float value) {
    bvec4 inside = lessThanEqual(values, vec4(value));
    if (!any(inside)) return kNoSurface;
    return surface_of(values, greatest(mix(vec4(-kInfinity), values, inside)));
}

// Linear interpolation that is exact at both ends and on plateaus, so that cells which share a face
// agree on it to the last bit, and a field that equals an isovalue somewhere is inside there.
float between(float a, float b, float w) {
    precise float x = w < 0.5 ? a + (b - a) * w : b - (b - a) * (1.0 - w);
    return x;
}
vec2 between(vec2 a, vec2 b, float w) {
    precise vec2 x = w < 0.5 ? a + (b - a) * w : b - (b - a) * (1.0 - w);
    return x;
}
vec4 between(vec4 a, vec4 b, float w) {
    precise vec4 x = w < 0.5 ? a + (b - a) * w : b - (b - a) * (1.0 - w);
    return x;
}

/// The voxels around a cell, by x: (y, z) in the order 00, 10, 01, 11.
struct Corners {
    vec4 x0;
    vec4 x1;
};
Corners corners_of(ivec3 cell) {
    ivec3 last = ivec3(constants.dims) - 1;
    ivec3 a = clamp(cell, ivec3(0), last), b = clamp(cell + 1, ivec3(0), last);
    Corners c;
    c.x0.x = texelFetch(volume, ivec3(a.x, a.y, a.z), 0).x;
    c.x0.y = texelFetch(volume, ivec3(a.x, b.y, a.z), 0).x;
    c.x0.z = texelFetch(volume, ivec3(a.x, a.y, b.z), 0).x;
    c.x0.w = texelFetch(volume, ivec3(a.x, b.y, b.z), 0).x;
    c.x1.x = texelFetch(volume, ivec3(b.x, a.y, a.z), 0).x;
    c.x1.y = texelFetch(volume, ivec3(b.x, b.y, a.z), 0).x;
    c.x1.z = texelFetch(volume, ivec3(b.x, a.y, b.z), 0).x;
    c.x1.w = texelFetch(volume, ivec3(b.x, b.y, b.z), 0).x;
    return c;
}

/// The field with full precision; filters of hardware have weights of 8 bits.
float exact_field(vec3 unit) {
    vec3 p = unit * vec3(constants.dims) - 0.5;
    vec3 w = p - floor(p);
    Corners c = corners_of(ivec3(floor(p)));
    vec4 x = between(c.x0, c.x1, w.x);
    vec2 y = between(x.xz, x.yw, w.y);
    return between(y.x, y.y, w.z);
}

/// World-space gradient by central differences over a voxel to either side, which is the trilinear
/// interpolation of those at the voxels. In texel units per world unit.
vec3 surface_gradient(vec3 unit) {
    vec3 slope = vec3(0.0); // per voxel
    [[dont_unroll]] for (int tap = 0; tap < 6; ++tap) { // 48 lookups are slow to compile
        vec3 aside = vec3(0.0);
        aside[tap >> 1] = (tap & 1) == 0 ? -1.0 : 1.0;
        slope += aside * (0.5 * exact_field(unit + aside / vec3(constants.dims)));
    }
    slope *= vec3(constants.dims);
    return constants.unit_from_world[0].xyz * slope.x + constants.unit_from_world[1].xyz * slope.y +
        constants.unit_from_world[2].xyz * slope.z;
}

/// Outward normal; where the gradient vanishes, the ray's opposite.
vec3 surface_normal(vec3 unit, vec3 direction) {
    vec3 g = surface_gradient(unit);
    float scale = max(max(abs(g.x), abs(g.y)), abs(g.z));
    return scale > 0.0 && scale < kInfinity ? -normalize(g / scale) : -direction;
}

/// A position from which rays can leave towards `direction` without meeting the surface it is on.
vec3 off_surface(vec3 position, vec3 normal, vec3 direction) {
    vec3 voxel = vec3(length(constants.world_from_unit[0]), length(constants.world_from_unit[1]),
        length(constants.world_from_unit[2])) / vec3(constants.dims);
    float aside = 0.02 * min(min(voxel.x, voxel.y), voxel.z);
    return position + normal * (dot(normal, direction) < 0.0 ? -aside : aside);
}

// A ray in coordinates whose integers are the voxel centres; cells lie between those. Which cell a t
// lies in follows from the ray and t alone: on every axis the one with t(entry) <= t < t(exit).
struct CellRay {
    vec3 origin;
    vec3 direction;
    vec3 inverse;
    bvec3 parallel; // to an axis' planes
    bvec3 forward;
};
CellRay make_cell_ray(vec3 origin, vec3 direction) {
    CellRay ray;
    ray.origin = unit_from_world(origin) * vec3(constants.dims) - 0.5;
    ray.direction = unit_from_world_direction(direction) * vec3(constants.dims);
    ray.parallel = lessThan(abs(ray.direction), vec3(1e-15));
    ray.direction = mix(ray.direction, vec3(0.0), ray.parallel);
    ray.inverse = 1.0 / mix(ray.direction, vec3(1.0), ray.parallel);
    ray.forward = greaterThanEqual(ray.direction, vec3(0.0));
    return ray;
}
vec3 place_at(CellRay ray, float t) {
    precise vec3 p = ray.origin + ray.direction * t;
    return p;
}
/// Where the ray meets the planes; those it is parallel to, at infinity.
vec3 planes_at(CellRay ray, ivec3 planes, float infinity) {
    precise vec3 t = (vec3(planes) - ray.origin) * ray.inverse;
    return mix(t, vec3(infinity), ray.parallel);
}
ivec3 entry_planes(CellRay ray, ivec3 cell) { return cell + mix(ivec3(1), ivec3(0), ray.forward); }
ivec3 exit_planes(CellRay ray, ivec3 cell) { return cell + mix(ivec3(0), ivec3(1), ray.forward); }
ivec3 cell_at(CellRay ray, float t) {
    ivec3 cell = ivec3(floor(place_at(ray, t))); // may be one off at planes
    ivec3 along = mix(ivec3(-1), ivec3(1), ray.forward);
    bvec3 early = lessThanEqual(planes_at(ray, exit_planes(ray, cell), kInfinity), vec3(t));
    bvec3 late = greaterThan(planes_at(ray, entry_planes(ray, cell), -kInfinity), vec3(t));
    return cell + along * (ivec3(early) - ivec3(late));
}

/// The cubic along the ray from `a` to `b`, positions in the cell: its control values.
vec4 cubic_between(Corners c, vec3 a, vec3 b) {
    vec4 xa = between(c.x0, c.x1, a.x), xb = between(c.x0, c.x1, b.x);
    vec2 aa = between(xa.xz, xa.yw, a.y), ab = between(xa.xz, xa.yw, b.y);
    vec2 ba = between(xb.xz, xb.yw, a.y), bb = between(xb.xz, xb.yw, b.y);
    float start = between(aa.x, aa.y, a.z), end = between(bb.x, bb.y, b.z);
    vec3 one = vec3(between(ba.x, ba.y, a.z), between(ab.x, ab.y, a.z), between(aa.x, aa.y, b.z));
    vec3 two = vec3(between(bb.x, bb.y, a.z), between(ba.x, ba.y, b.z), between(ab.x, ab.y, b.z));
    return vec4(start, start + dot(one - start, vec3(1.0 / 3.0)), end + dot(two - end, vec3(1.0 / 3.0)), end);
}
float cubic_at(vec4 b, float s) { // de Casteljau
    precise vec3 c = b.xyz + (b.yzw - b.xyz) * s;
    precise vec2 d = c.xy + (c.yz - c.xy) * s;
    precise float e = d.x + (d.y - d.x) * s;
    return e;
}
/// Where the cubic turns, ascending; 1 where it does not within (0, 1).
vec2 cubic_extrema(vec4 b) {
    vec3 d = b.yzw - b.xyz; // the derivative's control values: A s^2 + 2 B s + C
    float A = d.x - 2.0 * d.y + d.z, B = d.y - d.x, C = d.x;
    float discriminant = B * B - A * C;
    if (!(discriminant > 0.0)) return vec2(1.0);
    float q = B < 0.0 ? sqrt(discriminant) - B : -sqrt(discriminant) - B;
    float r = abs(q) < abs(A) ? q / A : 1.0, s = abs(C) < abs(q) ? C / q : 1.0;
    r = r > 0.0 ? r : 1.0;
    s = s > 0.0 ? s : 1.0;
    return vec2(min(r, s), max(r, s));
}

/// The first crossing of any isovalue in (t0, t1), from either side; t0 and t1 in the box, as of
/// clip_ray. With `start_solid`, a start at or above an isovalue is a hit at t0, with `entry_normal`
/// (0: the ray's opposite). False: none, hit.t = t1; or, where the budget of loop iterations is used
/// up, hit.t < t1: call again with t0 = hit.t and no start_solid, and the results are those of one
/// search, bit for bit. A call always gets somewhere, whatever the budget.
bool find_surface(vec3 origin, vec3 direction, float t0, float t1, bool start_solid, vec3 entry_normal,
    inout uint budget, out SurfaceHit hit) {
    hit = SurfaceHit(t1, kNoSurface, vec3(0.0), false);
    vec4 values = isovalues();
    float base = values.x; // all from here on is relative to it, for precision beside it
    values -= base;
    CellRay ray = make_cell_ray(origin, direction);
    ivec3 cell = cell_at(ray, t0), last = ivec3(constants.dims) - 1;

    // Of the cell with the crossing: the cubic, the part of it that crosses, and what it crosses.
    vec4 cubic = vec4(0.0);
    float low = 0.0, high = 1.0, target = kInfinity;
    float t = t0, t_exit = t0;
    uint around = kNoSurface; // the start
    bool unsure_start = start_solid, going = true;
    while (going) { // without break or return: a driver's lanes went on behind them
        budget -= min(budget, 1u);
        // Range cell i holds the extremes of the cells 8 i - 1 to 8 i + 7.
        ivec3 block = clamp((cell + 1) >> 3, ivec3(0), ivec3(constants.cells) - 1);
        vec2 range = cell_range(uint((block.z * int(constants.cells.y) + block.y) * int(constants.cells.x) + block.x));
        range -= base;
        bool skip = on_one_side(values, range.x, range.y);

        ivec3 exits = exit_planes(ray, cell);
        ivec3 block_exits = mix(block * RANGE_CELL - 1, max(block * RANGE_CELL + RANGE_CELL - 1, exits), ray.forward);
        vec3 t_planes = planes_at(ray, skip ? block_exits : exits, kInfinity);
        t_exit = min(min(min(t_planes.x, t_planes.y), t_planes.z), t1);

        float start = range.x; // or any other value in a cell on one side
        if (!skip) {
            Corners c = corners_of(cell);
            c.x0 -= base;
            c.x1 -= base;
            float lowest = min(least(c.x0), least(c.x1)), highest = max(greatest(c.x0), greatest(c.x1));
            start = lowest;
            if (!on_one_side(values, lowest, highest)) {
                // Exact coordinates on the planes that bound it: both cells there see one value.
                vec3 a = clamp(place_at(ray, t) - vec3(cell), 0.0, 1.0);
                vec3 b = clamp(place_at(ray, t_exit) - vec3(cell), 0.0, 1.0);
                vec3 near_side = mix(vec3(1.0), vec3(0.0), ray.forward);
                a = mix(a, near_side, equal(planes_at(ray, entry_planes(ray, cell), -kInfinity), vec3(t)));
                b = mix(b, 1.0 - near_side, equal(t_planes, vec3(t_exit)));
                cubic = cubic_between(c, a, b);
                start = cubic.x;
                vec2 turns = cubic_extrema(cubic);
                float first = cubic_at(cubic, turns.x), second = cubic_at(cubic, turns.y);
                if (turns.x == 1.0) first = cubic.w; // exact, as the next cell has it
                if (turns.y == 1.0) second = cubic.w;
                low = 0.0, high = turns.x;
                target = first_crossed(values, cubic.x, first);
                if (target == kInfinity) {
                    low = turns.x, high = turns.y;
                    target = first_crossed(values, first, second);
                }
                if (target == kInfinity) {
                    low = turns.y, high = 1.0;
                    target = first_crossed(values, second, cubic.w);
                }
            }
        }
        if (unsure_start) around = surface_around(values, start);
        unsure_start = false;
        going = around == kNoSurface && target == kInfinity;
        if (going) {
            bvec3 crossed = lessThanEqual(t_planes, vec3(t_exit));
            ivec3 beyond = skip ? block_exits + mix(ivec3(-1), ivec3(0), ray.forward)
                                : cell + mix(ivec3(-1), ivec3(1), ray.forward);
            cell = mix(skip ? cell_at(ray, t_exit) : cell, beyond, crossed);
            t = t_exit;
            going = t < t1 && budget > 0u && all(greaterThanEqual(cell, ivec3(-1))) && all(lessThanEqual(cell, last));
        }
    }

    if (around != kNoSurface) {
        hit = SurfaceHit(t0, around, entry_normal == vec3(0.0) ? -direction : entry_normal, true);
        return true;
    }
    if (target == kInfinity) {
        if (budget == 0u) hit.t = t;
        return false;
    }
    bool rising = cubic_at(cubic, low) < target;
    if (low == 0.0) rising = cubic.x < target;
    [[unroll]] for (int i = 0; i < 18; ++i) { // to 2^-18 of a cell; the end stays on the far side
        float middle = 0.5 * (low + high);
        if ((cubic_at(cubic, middle) < target) == rising) low = middle;
        else high = middle;
    }
    hit.t = mix(t, t_exit, high);
    hit.surface = surface_of(values, target);
    hit.normal = surface_normal(unit_from_world(origin + hit.t * direction), direction);
    return true;
}

#endif

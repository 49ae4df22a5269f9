// SPDX-License-Identifier: Apache-2.0
// The participating medium: field, transfer function, extinction, the part of a ray inside it.
// Every kernel on volumes includes this first. Bindings 0 to 9 belong to the medium and its
// surfaces, those of a kernel begin at 10.
//   EMISSION  the transfer function emits
#ifndef OCKHAM_VOLUME_MEDIUM_GLSL
#define OCKHAM_VOLUME_MEDIUM_GLSL

#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "shared/volume.h"

#ifndef MEDIUM_BINDING // kernels of surfaces have a frame of their own, and bindings before these
#define MEDIUM_BINDING 0
#define medium_frame frame
#endif
layout(scalar, binding = MEDIUM_BINDING) uniform MediumFrame { VolumeFrame data; } medium_frame;
// Read once: a driver may load again, for each lane, what a loop reads. Of arrays, what has a constant
// index.
VolumeFrame constants = medium_frame.data;
layout(binding = MEDIUM_BINDING + 1) uniform sampler3D volume; // linear, clamped
layout(scalar, binding = MEDIUM_BINDING + 2) readonly buffer Transfer { vec4 entries[]; } transfer; // colour, opacity
#ifdef EMISSION
layout(scalar, binding = MEDIUM_BINDING + 3) readonly buffer Emission { vec3 entries[]; } emission; // radiance
#endif

const float kInfinity = 1e30;

struct Medium {
    float sigma_t; // per world unit
    vec3 albedo;
#ifdef EMISSION
    vec3 emitted; // Le
#endif
};

vec3 unit_from_world(vec3 world) {
    vec4 p = vec4(world, 1.0);
    return vec3(dot(constants.unit_from_world[0], p), dot(constants.unit_from_world[1], p),
        dot(constants.unit_from_world[2], p));
}
vec3 unit_from_world_direction(vec3 direction) {
    return vec3(dot(constants.unit_from_world[0].xyz, direction),
        dot(constants.unit_from_world[1].xyz, direction), dot(constants.unit_from_world[2].xyz, direction));
}
vec3 world_from_unit(vec3 unit) { return constants.corner + constants.world_from_unit * unit; }

/// The field at unit coordinates: trilinear between voxel centres, clamped to the outermost.
float field(vec3 unit) { return textureLod(volume, unit, 0.0).x; }

/// Entry of the transfer table, and how far to the next.
void table_place(float value, out uint entry, out float fraction) {
    float x = clamp((value - constants.table_first) * constants.table_scale, 0.0,
        float(constants.table_size - 1u));
    entry = min(uint(x), constants.table_size - 2u);
    fraction = x - float(entry);
}

Medium medium_of(float value) {
    uint entry;
    float fraction;
    table_place(value, entry, fraction);
    vec4 row = mix(transfer.entries[entry], transfer.entries[entry + 1u], fraction);
    Medium medium;
    medium.sigma_t = constants.density_scale * row.w;
    medium.albedo = constants.albedo * row.xyz;
#ifdef EMISSION
    medium.emitted = mix(emission.entries[entry], emission.entries[entry + 1u], fraction);
#endif
    return medium;
}

/// sigma_t of medium_of(), which reads more.
float extinction_of(float value) {
    uint entry;
    float fraction;
    table_place(value, entry, fraction);
    return constants.density_scale *
        mix(transfer.entries[entry].w, transfer.entries[entry + 1u].w, fraction);
}

/// The part [near, far] of a world-space ray that lies inside the box, the crop box and the clip
/// planes, from t = 0 on; false if there is none. `entry_normal`: outward normal of the plane that
/// it enters by; 0 where it starts inside.
bool clip_ray(vec3 origin, vec3 direction, out float near, out float far, out vec3 entry_normal) {
    vec3 o = unit_from_world(origin), d = unit_from_world_direction(direction);
    // Parallel to a side: a crossing far away, before or behind.
    vec3 inverse = 1.0 / mix(d, vec3(1e-20), lessThan(abs(d), vec3(1e-20)));
    vec3 a = (constants.crop_min - o) * inverse, b = (constants.crop_max - o) * inverse;
    vec3 entries = min(a, b), exits = max(a, b);
    near = max(max(entries.x, entries.y), max(entries.z, 0.0));
    far = min(min(exits.x, exits.y), exits.z);
    int axis = entries.x == near ? 0 : entries.y == near ? 1 : 2;
    vec3 away = -sign(inverse[axis]) * constants.unit_from_world[axis].xyz; // the rows grow inwards
    entry_normal = near > 0.0 ? normalize(away) : vec3(0.0);
    for (uint i = 0u; i < constants.clip_count; ++i) {
        vec4 plane = medium_frame.data.clip_planes[i];
        float height = dot(plane.xyz, origin) + plane.w, slope = dot(plane.xyz, direction);
        if (slope == 0.0) {
            if (height < 0.0) return false;
            continue;
        }
        float t = -height / slope;
        if (slope < 0.0) {
            far = min(far, t);
        } else if (t > near) {
            near = t;
            entry_normal = -normalize(plane.xyz);
        }
    }
    return near < far;
}

/// A world-space ray through a point of the picture; `pixel` in pixels, (0, 0) the upper left corner.
void camera_ray(vec2 pixel, out vec3 origin, out vec3 direction) {
    vec2 p = pixel / vec2(constants.size) * vec2(2.0, -2.0) + vec2(-1.0, 1.0);
    vec3 aside = p.x * constants.right + p.y * constants.up;
    bool flat_view = constants.orthographic != 0u;
    origin = constants.position + (flat_view ? aside : vec3(0.0));
    direction = normalize(flat_view ? constants.forward : constants.forward + aside);
}

#endif

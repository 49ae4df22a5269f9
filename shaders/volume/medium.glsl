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

layout(scalar, binding = 0) readonly buffer Frame { VolumeFrame data; } frame;
layout(binding = 1) uniform sampler3D volume; // linear, clamped
layout(scalar, binding = 2) readonly buffer Transfer { vec4 entries[]; } transfer; // colour, opacity
#ifdef EMISSION
layout(scalar, binding = 3) readonly buffer Emission { vec3 entries[]; } emission; // radiance
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
    return vec3(dot(frame.data.unit_from_world[0], p), dot(frame.data.unit_from_world[1], p),
        dot(frame.data.unit_from_world[2], p));
}
vec3 unit_from_world_direction(vec3 direction) {
    return vec3(dot(frame.data.unit_from_world[0].xyz, direction),
        dot(frame.data.unit_from_world[1].xyz, direction), dot(frame.data.unit_from_world[2].xyz, direction));
}
vec3 world_from_unit(vec3 unit) { return frame.data.corner + frame.data.world_from_unit * unit; }

/// The field at unit coordinates: trilinear between voxel centres, clamped to the outermost.
float field(vec3 unit) { return textureLod(volume, unit, 0.0).x; }

/// Entry of the transfer table, and how far to the next.
void table_place(float value, out uint entry, out float fraction) {
    float x = clamp((value - frame.data.table_first) * frame.data.table_scale, 0.0,
        float(frame.data.table_size - 1u));
    entry = min(uint(x), frame.data.table_size - 2u);
    fraction = x - float(entry);
}

Medium medium_of(float value) {
    uint entry;
    float fraction;
    table_place(value, entry, fraction);
    vec4 row = mix(transfer.entries[entry], transfer.entries[entry + 1u], fraction);
    Medium medium;
    medium.sigma_t = frame.data.density_scale * row.w;
    medium.albedo = frame.data.albedo * row.xyz;
#ifdef EMISSION
    medium.emitted = mix(emission.entries[entry], emission.entries[entry + 1u], fraction);
#endif
    return medium;
}

/// The part [near, far] of a world-space ray that lies inside the box, the crop box and the clip
/// planes, from t = 0 on; false if there is none. `entry_normal`: outward normal of the plane that
/// it enters by; 0 where it starts inside.
bool clip_ray(vec3 origin, vec3 direction, out float near, out float far, out vec3 entry_normal) {
    vec3 o = unit_from_world(origin), d = unit_from_world_direction(direction);
    near = 0.0;
    far = kInfinity;
    entry_normal = vec3(0.0);
    for (int axis = 0; axis < 3; ++axis) {
        float low = frame.data.crop_min[axis], high = frame.data.crop_max[axis];
        if (d[axis] == 0.0) { // parallel: in or out as a whole
            if (o[axis] < low || o[axis] > high) return false;
            continue;
        }
        float a = (low - o[axis]) / d[axis], b = (high - o[axis]) / d[axis];
        if (min(a, b) > near) {
            near = min(a, b);
            vec3 towards = frame.data.unit_from_world[axis].xyz; // grows along the axis
            entry_normal = normalize(d[axis] > 0.0 ? -towards : towards);
        }
        far = min(far, max(a, b));
    }
    for (uint i = 0u; i < frame.data.clip_count; ++i) {
        vec4 plane = frame.data.clip_planes[i];
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
    vec2 p = pixel / vec2(frame.data.size) * vec2(2.0, -2.0) + vec2(-1.0, 1.0);
    vec3 aside = p.x * frame.data.right + p.y * frame.data.up;
    bool flat_view = frame.data.orthographic != 0u;
    origin = frame.data.position + (flat_view ? aside : vec3(0.0));
    direction = normalize(flat_view ? frame.data.forward : frame.data.forward + aside);
}

#endif

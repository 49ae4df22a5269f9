// SPDX-License-Identifier: Apache-2.0
// Transmittance of a straight way through the medium and its surfaces, without random numbers, so
// that shadows stay smooth:
//   T = exp(-int sigma_t dt) * product of (1 - opacity) over the surfaces met
// Two Gauss points per step of a voxel, so exact where the medium is homogeneous; what is empty is
// stepped over. Needs GRID and SURFACES; whether there are any is said by specialisation. Loop
// iterations: transmittance_iterations() of
// passes/volume/medium_inputs.hpp.
#ifndef OCKHAM_VOLUME_TRANSMITTANCE_GLSL
#define OCKHAM_VOLUME_TRANSMITTANCE_GLSL

#include "volume/cells.glsl"
#include "volume/surface.glsl"
#include "volume/meshes.h"

layout(constant_id = SPEC_MEDIUM_GRID) const bool kMediumGrid = true;
layout(constant_id = SPEC_MEDIUM_SURFACES) const bool kMediumSurfaces = true;
layout(constant_id = SPEC_ISO_SAMPLES) const bool kIsoSamples = false;

const float kOpaqueDepth = 6.2383246; // log(512): a composition ends there too

/// Optical depth between two places on a ray, in the box; beyond kOpaqueDepth, any such number.
float optical_depth(vec3 unit_origin, vec3 unit_direction, float near, float far) {
    float voxels = (far - near) * length(unit_direction * vec3(constants.dims));
    float steps = ceil(voxels), h = (far - near) / steps, depth = 0.0;
    CellWalk walk = walk_cells(unit_origin, unit_direction, near);
    for (float i = 0.0; i < steps && depth < kOpaqueDepth; i += 1.0) {
        float t = near + i * h;
        bool skip = false;
        if (kMediumGrid) {
            walk.cell = clamp(ivec3(floor(walk.origin + t * walk.direction)), ivec3(0),
                ivec3(constants.cells) - 1);
            float majorant = enter_cell(walk), exit = cell_exit(walk);
            skip = majorant <= 0.0 && exit >= t + h; // to the last step that ends in what is empty
            if (skip) i = max(i, min(floor((exit - near) / h), steps) - 1.0);
        }
        vec3 middle = unit_origin + (t + 0.5 * h) * unit_direction;
        vec3 aside = 0.28867513 * h * unit_direction;
        float sigma = extinction_of(field(middle - aside)) + extinction_of(field(middle + aside));
        depth += skip ? 0.0 : 0.5 * h * sigma;
    }
    return depth;
}

/// Product over the isosurfaces met. With `start_solid`, a ray that starts in a solid sees nothing.
float through_surfaces(vec3 origin, vec3 direction, float near, float far, bool start_solid,
    vec3 entry_normal) {
    uint budget = constants.dims.x + constants.dims.y + constants.dims.z + 64u;
    float value = 1.0, t = near;
    bool start = start_solid;
    while (t < far && value > 0.0 && budget > 0u) {
        SurfaceHit hit;
        bool met = find_surface(origin, direction, t, far, start, entry_normal, budget, hit);
        start = false;
        t = hit.t;
        if (met) {
            value *= 1.0 - medium_frame.data.surfaces[hit.surface].opacity;
            t += beyond_hit();
        }
    }
    return value;
}

/// Of the first `end` world units of a ray; direction: unit. Surfaces are looked for from `beside` the
/// origin; start_solid: that may be in a solid.
float transmittance(vec3 origin, vec3 beside, vec3 direction, float end, bool start_solid) {
    float near, far;
    vec3 entry_normal;
    bool inside = clip_ray(origin, direction, near, far, entry_normal);
    far = min(far, end);
    if (!inside || far <= near) return 1.0;
    float value = 1.0;
    if (kMediumSurfaces)
        value = through_surfaces(beside, direction, near, far, start_solid, entry_normal);
    float depth = optical_depth(unit_from_world(origin), unit_from_world_direction(direction), near, far);
    return depth < kOpaqueDepth ? value * exp(-depth) : 0.0;
}

#endif

// SPDX-License-Identifier: Apache-2.0
// A volume as its kernels see it: where it lies, what its values mean, the light around it, the
// camera before it. Written by the program whenever one of these changes. Values of the field are
// in texel units (what a texture lookup gives); the host converts data units.
#ifndef OCKHAM_SHADERS_SHARED_VOLUME_H
#define OCKHAM_SHADERS_SHARED_VOLUME_H

#include "shared/frame.h"
#include "shared/types.h"

OCKHAM_SHARED_BEGIN

#define RANGE_CELL 8      // voxels along a side of a cell of ranges and majorants
#define MAX_SURFACES 4    // isovalues at once
#define MAX_CLIP_PLANES 4 // beside the crop box

#define SHADING_LAMBERT 0u
#define SHADING_PHONG 1u
#define SHADING_DISNEY 2u

/// Parameters of Burley 2012, all in [0, 1] but base_color (linear, >= 0).
struct IsoMaterial {
    vec3 base_color;
    float metallic;
    float subsurface;
    float specular;
    float roughness;
    float specular_tint;
    float anisotropic;
    float sheen;
    float sheen_tint;
    float clearcoat;
    float clearcoat_gloss;
};

struct IsoSurface {
    float value;   ///< the surface is where the field is this; inside, it is more
    float opacity; ///< chance that light meets it: 1 hides what is behind
    IsoMaterial material;
};

struct VolumeFrame {
    // Place. Unit coordinates run over the box, 0 to 1 along each data axis; voxel centres lie at
    // (i + 1/2) / dims.
    vec4 unit_from_world[3]; ///< rows of an affine map
    mat3 world_from_unit;    ///< its linear part's inverse: columns are the edges of the box
    vec3 corner;             ///< world position of unit 0
    vec3 crop_min;           ///< unit coordinates; the medium and its surfaces end there
    vec3 crop_max;
    uint clip_count;
    vec4 clip_planes[MAX_CLIP_PLANES]; ///< world; kept where dot(xyz, p) + w >= 0
    uvec3 dims;                        ///< voxels
    uvec3 cells;                       ///< of ranges and majorants: dims / RANGE_CELL, rounded up

    // Medium. The transfer table's entry at a value: (value - table_first) * table_scale.
    float table_first;
    float table_scale;
    uint table_size;
    float density_scale; ///< extinction per world unit where the opacity is 1
    float albedo;        ///< times the colour: the scattering albedo
    float phase_g;       ///< Henyey-Greenstein, mean cosine, (-1, 1)
    float majorant;      ///< extinction per world unit, nowhere exceeded
    float emission_most; ///< luminance (Rec. 709) of the brightest emission

    // Light.
    vec3 light_direction;   ///< unit; the way that light travels
    vec3 light_irradiance;  ///< on a surface that faces it
    vec3 environment;       ///< radiance; of a map, its mean over all directions
    uvec2 environment_size; ///< texels of the map; 0: none

    // Surfaces.
    uint surface_count;
    uint shading; ///< SHADING_*
    IsoSurface surfaces[MAX_SURFACES];
    float surface_gain;
    float volume_gain;

    // Camera, as in shared/frame.h.
    vec3 position;
    vec3 right;
    vec3 up;
    vec3 forward;
    uint orthographic;
    uvec2 size; ///< pixels

    uint seed;
    uint max_bounces; ///< scatterings per path, ~0: as many as it takes

    // Meshes in the same world, where there are any.
    mat4 sun_projection; ///< as in shared/frame.h
    uint window;         ///< m: rays go through the centres of m x m samples per pixel
    uint sample_order[MAX_SAMPLES]; ///< as in shared/frame.h
};

OCKHAM_SHARED_END

#endif

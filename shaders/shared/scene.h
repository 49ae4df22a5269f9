// SPDX-License-Identifier: Apache-2.0
// The scene as the GPU sees it: vertices, instances, materials, lights. Written by scene_gpu.
#ifndef OCKHAM_SHADERS_SHARED_SCENE_H
#define OCKHAM_SHADERS_SHARED_SCENE_H

#include "shared/types.h"

OCKHAM_SHARED_BEGIN

/// Affine object-to-world transform: rows of a 3x4 matrix.
struct InstanceData {
    vec4 world_x;
    vec4 world_y;
    vec4 world_z;
};

/// Where texture coordinates come from: uv' = (dot(u, (uv, 1)), dot(v, (uv, 1))), then wrapped.
struct UvMap {
    vec3 u;
    vec3 v;
    vec2 inset; ///< half a texel: where clamped and mirrored coordinates stop before the border
    uint set;   ///< texture coordinate set, 0 or 1
    uint wrap;  ///< Wrap of u in bits 0-1, of v in bits 2-3
};

/// An image in one of the two texture arrays.
struct TextureRef {
    int layer; ///< -1: none
    uint slot; ///< which of the material's UvMaps, 0 or 1 (2: normal map's own)
    vec2 size; ///< native texels; the array's layers are padded to a common size
};

#define MATERIAL_UNLIT 1u

struct MaterialData {
    vec4 base_color;
    vec3 emissive;
    float metallic;
    float roughness;
    float reflectance; ///< at normal incidence, from the index of refraction
    float normal_scale;
    float occlusion_strength;
    float alpha_cutoff;
    uint flags;
    TextureRef base_color_texture;         ///< colour array
    TextureRef emissive_texture;           ///< colour array
    TextureRef metallic_roughness_texture; ///< data array
    TextureRef occlusion_texture;          ///< data array
    TextureRef normal_texture;             ///< data array
    UvMap uv[3];                           ///< slots 0 and 1, and the normal map's
};

// Of so many and fewer, kernels may read all from a uniform buffer: 16 KiB, which every device allows.
#define FEW_MATERIALS 64
#define FEW_LIGHTS 256

/// Up to TRIANGLES_PER_BLOCK (surface/gbuffer.h) triangles of one primitive in one instance.
struct TriangleBlock {
    uint first_index; ///< of its first triangle
    int vertex_offset;
    uint instance;
    uint material;
};

#define LIGHT_DIRECTIONAL 0u
#define LIGHT_POINT 1u
#define LIGHT_SPOT 2u

/// See scene/light.hpp for the formula. Directional lights come first, then points, then spots.
struct LightData {
    vec3 position;
    float inverse_range_squared; ///< 0 = no range
    vec3 to_light;               ///< unit; directional: towards the light; spot: against its axis
    float softening;
    vec3 intensity;
    float window_half_power; ///< exponent of (d^2 / range^2)
    float cone_scale;        ///< spot: saturate(cos * scale + offset)^2
    float cone_offset;
};

OCKHAM_SHARED_END

#endif

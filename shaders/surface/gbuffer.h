// SPDX-License-Identifier: Apache-2.0
// Constants of the G-buffer: its draws, its specialisation, and how the visibility layout counts
// triangles.
#ifndef OCKHAM_SHADERS_SURFACE_GBUFFER_H
#define OCKHAM_SHADERS_SURFACE_GBUFFER_H

#include "shared/types.h"

OCKHAM_SHARED_BEGIN

struct DrawPush {
    uint material;
};

/// Of a draw without an index buffer: what makes triangle ids of gl_VertexIndex, gl_InstanceIndex.
struct VisibilityPush {
    uint material;
    uint first_index;
    int vertex_offset;
    uint first_instance;
    uint first_triangle;         ///< id of the first instance's first triangle
    uint triangles_per_instance; ///< ids from one instance to the next
    vec2 steps;                  ///< of 1/256 sample across half the viewport
};

// A triangle's id is the block it is in, and its number there. Block 0 holds none.
#define TRIANGLE_BLOCK_BITS 8
#define TRIANGLES_PER_BLOCK (1u << TRIANGLE_BLOCK_BITS)
#define NO_TRIANGLE 0u // background

// Of packed samples: the material of the first isosurface, the others follow. Scenes have fewer.
#define ISO_MATERIAL 0xfffff0u

// Specialisation: vec4s from one vertex to the next, and which of them holds an attribute
// (ATTRIBUTE_ABSENT: the scene has none). Numbers apart from those of shade.h: kernels that shade
// from the visibility layout have both.
#define SPEC_VERTEX_STRIDE 16
#define SPEC_TANGENT_OFFSET 17
#define SPEC_UV1_OFFSET 18
#define SPEC_COLOR_OFFSET 19
#define ATTRIBUTE_ABSENT 0xffffffffu
#define SPEC_NORMAL_MAPS 22          // bool: a material has one
#define SPEC_SHADING_DATA_TEXTURES 23 // bool: ... a metallic-roughness or occlusion image
#define SPEC_SECOND_COORDINATES 24   // bool: ... images with two different sets of coordinates
#define ATTRIBUTE_ABSENT 0xffffffffu

OCKHAM_SHARED_END

#endif

// SPDX-License-Identifier: Apache-2.0
// writes the triangle's id; MASKED: reads the base colour's alpha and discards where the material
// is a hole.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "include/footprint.glsl"
#include "surface/gbuffer.h"
#include "surface/material.glsl"

layout(location = 0) flat in uint in_triangle;
#ifdef MASKED
layout(location = 1) in vec2 in_uv0;
layout(location = 2) in vec2 in_uv1;
layout(location = 3) in float in_alpha;

layout(scalar, binding = 3) readonly buffer Materials { MaterialData items[]; } materials;
#ifdef COLOR_TEXTURES
layout(binding = 4) uniform sampler2DArray color_textures;
#endif

layout(push_constant, scalar) uniform Push { VisibilityPush push; };
#endif

layout(location = 0) out uint out_triangle;

void main() {
#ifdef MASKED
    MaterialData material = materials.items[push.material];
    float alpha = material.base_color.a * in_alpha;
#ifdef COLOR_TEXTURES
    UvDerivatives derivatives = UvDerivatives(dFdx(in_uv0), dFdx(in_uv1), dFdy(in_uv0), dFdy(in_uv1));
    TextureCoordinates c = map_coordinates(material.uv[0], in_uv0, in_uv1, derivatives);
    if (material.base_color_texture.layer >= 0) {
        alpha *= sample_footprint(color_textures, material.base_color_texture.layer,
            material.base_color_texture.size, c.uv, c.gradient_x, c.gradient_y, 2.0).a;
    }
#endif
    if (alpha < material.alpha_cutoff) discard;
#endif
    out_triangle = in_triangle;
}

// SPDX-License-Identifier: Apache-2.0
// reads the base colour's alpha; discards where the material is a hole.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "include/footprint.glsl"
#include "surface/gbuffer.h"
#include "surface/material.glsl"

layout(location = 0) in vec2 in_uv0;
layout(location = 1) in vec2 in_uv1;
layout(location = 2) in float in_alpha;

layout(scalar, binding = 3) readonly buffer Materials { MaterialData items[]; } materials;
#ifdef COLOR_TEXTURES
layout(binding = 4) uniform sampler2DArray color_textures;
#endif

layout(push_constant, scalar) uniform Push { DrawPush push; };

void main() {
    MaterialData material = materials.items[push.material];
    float alpha = material.base_color.a * in_alpha;
#ifdef COLOR_TEXTURES
    vec2 uv = map_uv(material.uv[0], in_uv0, in_uv1);
    vec2 gradient_x = map_uv_change(material.uv[0], dFdx(in_uv0), dFdx(in_uv1));
    vec2 gradient_y = map_uv_change(material.uv[0], dFdy(in_uv0), dFdy(in_uv1));
    if (material.base_color_texture.layer >= 0) {
        alpha *= sample_footprint(color_textures, material.base_color_texture.layer,
            material.base_color_texture.size, wrap_uv(material.uv[0], uv), gradient_x, gradient_y,
            2.0).a;
    }
#endif
    if (alpha < material.alpha_cutoff) discard;
}

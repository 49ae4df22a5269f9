// SPDX-License-Identifier: Apache-2.0
// reads interpolated attributes, material; writes one packed surface sample (packing.glsl).
// Normal maps are applied here, per sample, so that the metrics see the bumps; albedo is not.
// SLOPES adds how steep the surface itself is, which bumps hide.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "include/footprint.glsl"
#include "surface/gbuffer.h"
#include "surface/material.glsl"
#include "surface/packing.glsl"

layout(location = 0) in vec3 in_normal;
layout(location = 1) in vec4 in_tangent;
layout(location = 2) in vec2 in_uv0;
layout(location = 3) in vec2 in_uv1;
layout(location = 4) in vec4 in_color;

#ifdef EXTRA
#define OUT_SLOPES 2
#else
#define OUT_SLOPES 1
#endif
layout(location = 0) out uvec4 out_surface;
#ifdef EXTRA
layout(location = 1) out uvec4 out_extra;
#endif
#ifdef SLOPES
layout(location = OUT_SLOPES) out uint out_slopes;
#endif

layout(scalar, binding = 3) readonly buffer Materials { MaterialData items[]; } materials;
#ifdef COLOR_TEXTURES
layout(binding = 4) uniform sampler2DArray color_textures;
#endif
#ifdef NORMAL_MAPPED
layout(binding = 5) uniform sampler2DArray data_textures;
#endif

layout(push_constant, scalar) uniform Push { DrawPush push; };

TextureCoordinates coordinates(UvMap map, UvDerivatives d) {
    return map_coordinates(map, in_uv0, in_uv1, d);
}

void main() {
    MaterialData material = materials.items[push.material];
    // First of all, for derivatives end at a discard.
    UvDerivatives derivatives = UvDerivatives(dFdx(in_uv0), dFdx(in_uv1), dFdy(in_uv0), dFdy(in_uv1));
#ifdef SLOPES
    out_slopes = packHalf2x16(vec2(dFdx(gl_FragCoord.z), dFdy(gl_FragCoord.z)) / gl_FragCoord.z);
#endif
    TextureCoordinates c = coordinates(material.uv[0], derivatives);

#ifdef MASKED
    float alpha = material.base_color.a * in_color.a;
#ifdef COLOR_TEXTURES
    if (material.base_color_texture.layer >= 0) {
        alpha *= sample_footprint(color_textures, material.base_color_texture.layer,
            material.base_color_texture.size, c.uv, c.gradient_x, c.gradient_y, 2.0).a;
    }
#endif
    if (alpha < material.alpha_cutoff) discard;
#endif

    vec3 normal = normalize(in_normal);
#ifdef NORMAL_MAPPED
    if (material.normal_texture.layer >= 0) {
        TextureCoordinates bump = coordinates(material.uv[2], derivatives);
        vec3 texel = sample_footprint(data_textures, material.normal_texture.layer,
            material.normal_texture.size, bump.uv, bump.gradient_x, bump.gradient_y, 2.0).xyz;
        normal = bump_normal(normal, in_tangent, texel, material.normal_scale);
    }
#endif
    if (!gl_FrontFacing) normal = -normal;

    out_surface = pack_surface(normal, push.material, c);
#ifdef EXTRA
    out_extra = uvec4(pack_color(in_color.rgb), pack_coordinates(coordinates(material.uv[1], derivatives)));
#endif
}

// SPDX-License-Identifier: Apache-2.0
// reads interpolated attributes, material; writes one packed surface sample (packing.glsl).
// Normal maps are applied here, per sample, so that the metrics see the bumps; albedo is not.
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

layout(location = 0) out uvec4 out_surface;
#ifdef EXTRA
layout(location = 1) out uvec4 out_extra;
#endif

layout(scalar, binding = 3) readonly buffer Materials { MaterialData items[]; } materials;
#ifdef COLOR_TEXTURES
layout(binding = 4) uniform sampler2DArray color_textures;
#endif
#ifdef NORMAL_MAPPED
layout(binding = 5) uniform sampler2DArray data_textures;
#endif

layout(push_constant, scalar) uniform Push { DrawPush push; };

/// Derivatives of the vertices' coordinates; taken first of all, for they end at a discard.
struct UvDerivatives {
    vec2 x0, x1, y0, y1;
};

TextureCoordinates coordinates(UvMap map, UvDerivatives d) {
    TextureCoordinates c;
    vec2 uv = map_uv(map, in_uv0, in_uv1);
    vec2 direction = wrap_direction(map, uv);
    c.gradient_x = map_uv_change(map, d.x0, d.x1) * direction;
    c.gradient_y = map_uv_change(map, d.y0, d.y1) * direction;
    c.uv = wrap_uv(map, uv);
    return c;
}

void main() {
    MaterialData material = materials.items[push.material];
    UvDerivatives derivatives = UvDerivatives(dFdx(in_uv0), dFdx(in_uv1), dFdy(in_uv0), dFdy(in_uv1));
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
        vec3 t = sample_footprint(data_textures, material.normal_texture.layer,
            material.normal_texture.size, bump.uv, bump.gradient_x, bump.gradient_y, 2.0).xyz;
        t = (2.0 * t - 1.0) * vec3(material.normal_scale, material.normal_scale, 1.0);
        vec3 tangent = in_tangent.xyz - normal * dot(normal, in_tangent.xyz);
        float tangent_length = length(tangent);
        if (tangent_length > 0.0) {
            tangent /= tangent_length;
            vec3 bitangent = cross(normal, tangent) * in_tangent.w;
            normal = normalize(t.x * tangent + t.y * bitangent + t.z * normal);
        }
    }
#endif
    if (!gl_FrontFacing) normal = -normal;

    out_surface = pack_surface(normal, push.material, c);
#ifdef EXTRA
    out_extra = uvec4(pack_color(in_color.rgb), pack_coordinates(coordinates(material.uv[1], derivatives)));
#endif
}

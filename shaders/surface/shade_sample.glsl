// SPDX-License-Identifier: Apache-2.0
// shade_sample: radiance towards the camera from one sample of the G-buffer, by all lights.
// Shared by first_sample.comp and shade.comp, so that their results are equal bit for bit.

#include "include/attenuation.glsl"
#include "include/bsdf.glsl"
#include "include/footprint.glsl"
#include "include/sun_map.glsl"
#include "shared/frame.h"
#include "surface/material.glsl"
#include "surface/shade.h"

layout(constant_id = SPEC_DIRECTIONAL_LIGHTS) const bool kDirectionalLights = true;
layout(constant_id = SPEC_POINT_LIGHTS) const bool kPointLights = true;
layout(constant_id = SPEC_SPOT_LIGHTS) const bool kSpotLights = true;
layout(constant_id = SPEC_MANY_LIGHTS) const bool kManyLights = false;

layout(scalar, binding = 0) uniform Frame { FrameData data; } frame;
#include "surface/surface_sample.glsl"
#include "surface/materials.glsl"
layout(scalar, binding = 5) readonly buffer Lights { LightData items[]; } lights;
layout(scalar, binding = 40) uniform FewLights { LightData items[FEW_LIGHTS]; } few_lights; // as materials
#ifdef COLOR_TEXTURES
layout(binding = 6) uniform sampler2DArray color_textures;
#endif
#if defined(DATA_TEXTURES) && !defined(VISIBILITY)
layout(binding = 7) uniform sampler2DArray data_textures;
#endif
#ifdef SHADOW
layout(binding = 8) uniform sampler2D shadow_map;
#endif

#include "surface/lit_through.glsl"
#include "surface/isosurface.glsl"

layout(push_constant, scalar) uniform Push { ShadePush push; };

/// A sample of a pixel's window to be shaded, and what it stands for.
struct Pick {
    uint index;       // in the window, row-major
    float weight;     // of its colour in the sum of k; all weights add up to k
    float widening;   // how much wider than one sample, per axis, the part of the pixel is
    float roughening; // what the normals there add to alpha^2
    uint albedo;      // mean base colour there, as pack_color() has it; 0: its own
};

/// Factors by which the sample's own footprint is widened along x and y. `offset`: its place in the
/// window.
vec2 footprint_scale(ivec2 position, ivec2 offset, SurfaceSample s, float widening) {
    if (widening <= 1.0) return vec2(1.0);
    // The footprint is centred on the sample, so both ends of the window may stop it; a sample that
    // stands at one end, as all do at m = 2, has one to compare. Loops, since software drivers
    // execute both sides of a branch.
    ivec2 end = ivec2(int(frame.data.m) - 1) - offset;
    bool stop_x = false, stop_y = false;
    for (int i = offset.x > 0 ? 0 : 1, last = end.x > 0 ? 2 : 1; i < last; ++i) {
        stop_x = stop_x || discontinuous(position, s, ivec2(i == 0 ? -offset.x : end.x, 0));
    }
    for (int i = offset.y > 0 ? 0 : 1, last = end.y > 0 ? 2 : 1; i < last; ++i) {
        stop_y = stop_y || discontinuous(position, s, ivec2(0, i == 0 ? -offset.y : end.y));
    }
    return vec2(stop_x ? 1.0 : widening, stop_y ? 1.0 : widening);
}

#if defined(COLOR_TEXTURES) || defined(DATA_TEXTURES)
vec4 lookup(sampler2DArray image, TextureRef texture_ref, SurfaceSample s, vec2 scale) {
    TextureCoordinates c = s.coordinates[texture_ref.slot];
    return sample_footprint(image, texture_ref.layer, texture_ref.size, c.uv, c.gradient_x * scale.x,
        c.gradient_y * scale.y, push.anisotropy);
}
#endif

#ifdef SHADOW
/// How far a sample may lie off its surface, world units: rasterisers move corners to a grid, which
/// Vulkan wants no coarser than 1/16 sample, and interpolate depth from there.
float surface_error(float depth) {
    float sample_size = 2.0 * length(frame.data.up) / float(frame.data.picture.y * frame.data.m);
    return (frame.data.orthographic != 0u ? 1.0 : depth) * sample_size / 16.0;
}

/// Share of the sun that meshes let through. `depth`: along the camera's axis.
float sun_visibility(vec3 world, float depth, vec3 normal, float n_l) {
    float slope = sqrt(clamp(1.0 - n_l * n_l, 0.0, 1.0));
    float lift = frame.data.sun_texel * (0.5 + 2.0 * slope) + surface_error(depth);
    vec3 lifted = world + normal * lift;
    vec4 p = frame.data.sun_projection * vec4(lifted, 1.0);
    return sun_map_share(shadow_map, p.xyz);
}
#endif

/// Dependent multiply-adds that cost time and change nothing: stands in for an expensive shader.
/// `x`: in [0,1], of this sample, lest it be done once for many. The factor returned is always 1,
/// which no compiler can know.
float stall(float x) {
    uint iterations = (push.stall + 15u) / 16u;
    for (uint i = 0u; i < iterations; ++i) {
        x = fma(x, 0.999, 1e-3); x = fma(x, 0.998, 2e-3); x = fma(x, 0.997, 3e-3); x = fma(x, 0.996, 4e-3);
        x = fma(x, 0.995, 5e-3); x = fma(x, 0.994, 6e-3); x = fma(x, 0.993, 7e-3); x = fma(x, 0.992, 8e-3);
        x = fma(x, 0.991, 9e-3); x = fma(x, 0.990, 1e-2); x = fma(x, 0.989, 1e-2); x = fma(x, 0.988, 1e-2);
        x = fma(x, 0.987, 1e-2); x = fma(x, 0.986, 1e-2); x = fma(x, 0.985, 1e-2); x = fma(x, 0.984, 1e-2);
    }
    return x < -1.0 ? 0.0 : 1.0;
}

LightData light_at(uint index) {
    if (kManyLights) return lights.items[index];
    return few_lights.items[index];
}

/// Radiance towards `v` per irradiance from `l`; material: the sample's.
vec3 reflect_from(Surface surface, uint material, vec3 n, vec3 v, vec3 l) {
    vec3 reflected = reflect_light(surface, n, v, l);
    // A loop, since software drivers execute both sides of a branch.
    for (bool iso = is_isosurface(material); iso; iso = false)
        reflected = reflect_isosurface(material, n, v, l);
    return reflected;
}

/// Returns linear radiance, and 1 where a surface is hit, 0 on background.
vec4 shade_sample(ivec2 pixel, Pick pick) {
    ivec2 offset = window_offset(int(pick.index));
    ivec2 position = pixel * int(frame.data.m) + offset;
    SurfaceSample s = fetch_surface(position);
    float unstalled = stall(s.depth);
    if (s.depth <= 0.0) return vec4(frame.data.background * unstalled, 0.0);

    bool iso = is_isosurface(s.material);
    MaterialData material = material_at(iso ? 0u : s.material);
    vec4 base_color = material.base_color;
    base_color.rgb *= s.color;
    vec3 emissive = material.emissive;
    float metallic = material.metallic;
    float roughness = material.roughness;
    float occlusion = 1.0;
#if defined(COLOR_TEXTURES) || defined(DATA_TEXTURES)
    vec2 scale = footprint_scale(position, offset, s, pick.widening);
#endif
#ifdef COLOR_TEXTURES
    if (pick.albedo == 0u && material.base_color_texture.layer >= 0)
        base_color *= lookup(color_textures, material.base_color_texture, s, scale);
    if (material.emissive_texture.layer >= 0)
        emissive *= lookup(color_textures, material.emissive_texture, s, scale).rgb;
#endif
#ifdef DATA_TEXTURES
    if (kShadingDataTextures && material.metallic_roughness_texture.layer >= 0) {
        vec4 t = lookup(data_textures, material.metallic_roughness_texture, s, scale);
        roughness *= t.g;
        metallic *= t.b;
    }
    if (kShadingDataTextures && material.occlusion_texture.layer >= 0) {
        float t = lookup(data_textures, material.occlusion_texture, s, scale).r;
        occlusion = 1.0 + material.occlusion_strength * (t - 1.0);
    }
#endif
    if (pick.albedo != 0u) base_color.rgb = unpack_color(pick.albedo);
    if (!iso && (material.flags & MATERIAL_UNLIT) != 0u) return vec4(base_color.rgb * unstalled, 1.0);

    Surface surface = make_surface(base_color.rgb, metallic, roughness, material.reflectance);
    surface.alpha2 = min(surface.alpha2 + pick.roughening, 1.0);
    float depth = view_depth(s.depth);
    vec3 world = sample_world(position, depth);
    vec3 v = to_camera(world);
    vec3 n = s.normal;
    vec3 radiance = emissive + frame.data.ambient * occlusion * (surface.diffuse + surface.reflectance);
    if (iso) radiance = isosurface_ambient(s.material);

    uint light = 0u;
    if (kDirectionalLights) {
        for (; light < frame.data.directional_count; ++light) {
            LightData source = light_at(light);
            vec3 l = source.to_light;
            float visible = 1.0;
#ifdef SHADOW
            if (light == 0u) visible = sun_visibility(world, depth, n, dot(n, l));
#endif
            visible *= lit_through(world, n, l, 1e30, iso);
            radiance += visible * source.intensity * reflect_from(surface, s.material, n, v, l);
        }
    }
    if (kPointLights) {
        uint end = light + frame.data.point_count;
        for (; light < end; ++light) {
            LightData source = light_at(light);
            vec3 to_light = source.position - world;
            float distance2 = dot(to_light, to_light);
            vec3 l = to_light * inversesqrt(max(distance2, 1e-12));
            radiance += attenuation(source, distance2) *
                        lit_through(world, n, l, sqrt(distance2), iso) * source.intensity *
                        reflect_from(surface, s.material, n, v, l);
        }
    }
    if (kSpotLights) {
        uint end = light + frame.data.spot_count;
        for (; light < end; ++light) {
            LightData source = light_at(light);
            vec3 to_light = source.position - world;
            float distance2 = dot(to_light, to_light);
            vec3 l = to_light * inversesqrt(max(distance2, 1e-12));
            float cone = clamp(dot(l, source.to_light) * source.cone_scale +
                                   source.cone_offset, 0.0, 1.0);
            radiance += attenuation(source, distance2) * cone * cone *
                        lit_through(world, n, l, sqrt(distance2), iso) *
                        source.intensity * reflect_from(surface, s.material, n, v, l);
        }
    }
    return vec4(radiance * unstalled, 1.0);
}

// SPDX-License-Identifier: Apache-2.0
// Reflection of isosurfaces: Lambert, Phong, Disney; evaluated, sampled, and the density of that.
// No material reflects more than it receives: where Burley's diffuse lobe and sheen would, they are
// clamped to what the specular lobe leaves. n, v, l are unit and point away from the surface; n to
// the viewer's side (a v below the horizon counts as grazing). "cos" is dot(n, l).
//   Lambert    base / pi
//   Phong      (1 - k) base / pi + k (e + 2) / 2 pi cos(mirror, l)^e,  k = 0.08 specular,
//              e = (1 / alpha^2 - 1) / 2, alpha = roughness^2       Lafortune and Willems 1994
//   Disney     Burley 2012, "Physically-based shading at Disney"; G of its code as revised
#ifndef OCKHAM_ISO_BSDF_GLSL
#define OCKHAM_ISO_BSDF_GLSL

#include "shared/volume.h"

const float kPi = 3.14159265;

// --- Lobes, in the frame of the surface: normal +z, brushed along x.

/// x runs along the horizon (y is up), so that anisotropic highlights do not turn with the view.
mat3 shading_frame(vec3 n) {
    vec3 x = abs(n.y) < 0.999 ? vec3(n.z, 0.0, -n.x) : vec3(1.0, 0.0, 0.0) - n.x * n;
    x = normalize(x);
    return mat3(x, cross(n, x), n);
}

float fifth_power(float x) { return (x * x) * (x * x) * x; }
float schlick(float cosine) { return fifth_power(clamp(1.0 - cosine, 0.0, 1.0)); }
float largest(vec3 c) { return max(max(c.x, c.y), c.z); }

/// Cosine-weighted.
vec3 sample_cosine(vec2 xi) {
    float r = sqrt(xi.x), angle = 2.0 * kPi * xi.y;
    return vec3(r * cos(angle), r * sin(angle), sqrt(max(1.0 - xi.x, 0.0)));
}
float cosine_pdf(vec3 l) { return max(l.z, 0.0) / kPi; }

/// cos^e around the mirror direction.
vec3 sample_mirror(float exponent, vec3 v, vec2 xi) {
    float cosine = pow(xi.x, 1.0 / (exponent + 1.0)), sine = sqrt(max(1.0 - cosine * cosine, 0.0));
    vec3 axis = vec3(-v.xy, v.z);
    vec3 side = normalize(abs(axis.z) < 0.7 ? vec3(-axis.y, axis.x, 0.0) : vec3(axis.z, 0.0, -axis.x));
    float angle = 2.0 * kPi * xi.y;
    return sine * (cos(angle) * side + sin(angle) * cross(axis, side)) + cosine * axis;
}
float mirror_power(float exponent, vec3 v, vec3 l) {
    float cosine = dot(vec3(-v.xy, v.z), l); // of 0 the power 0 is undefined
    return cosine > 0.0 ? pow(cosine, exponent) / (2.0 * kPi) : 0.0;
}
float phong_exponent(float roughness) {
    float alpha = max(roughness * roughness, 0.02);
    return 0.5 / (alpha * alpha) - 0.5;
}

/// GGX, anisotropic: Burley's GTR2.
float ggx(vec3 h, vec2 alpha) {
    vec3 s = vec3(h.xy / alpha, h.z);
    float d = dot(s, s);
    return h.z > 0.0 ? 1.0 / (kPi * alpha.x * alpha.y * d * d) : 0.0;
}
/// Smith's masking, divided by twice the cosine.
float masking(vec3 v, vec2 alpha) {
    vec2 s = alpha * v.xy;
    return 1.0 / (v.z + sqrt(v.z * v.z + dot(s, s)));
}
/// Normals as v sees them (Heitz 2018); their density as that of the mirrored l.
vec3 sample_ggx(vec3 v, vec2 alpha, vec2 xi) {
    vec3 view = normalize(vec3(alpha * v.xy, v.z));
    float across = dot(view.xy, view.xy);
    vec3 x = across > 0.0 ? vec3(-view.y, view.x, 0.0) * inversesqrt(across) : vec3(1.0, 0.0, 0.0);
    float r = sqrt(xi.x), angle = 2.0 * kPi * xi.y, s = 0.5 + 0.5 * view.z;
    float a = r * cos(angle), b = mix(sqrt(max(1.0 - a * a, 0.0)), r * sin(angle), s);
    vec3 n = a * x + b * cross(view, x) + sqrt(max(1.0 - a * a - b * b, 0.0)) * view;
    return normalize(vec3(alpha * n.xy, max(n.z, 1e-6)));
}
float ggx_pdf(vec3 v, vec3 h, vec2 alpha) { return dot(v, h) > 0.0 ? 0.5 * masking(v, alpha) * ggx(h, alpha) : 0.0; }

/// The clear coat's GTR1.
float gtr1(vec3 h, float alpha) {
    float a = alpha * alpha;
    return h.z > 0.0 ? (a - 1.0) / (kPi * log(a) * (dot(h.xy, h.xy) + a * h.z * h.z)) : 0.0;
}
vec3 sample_gtr1(float alpha, vec2 xi) {
    float a = alpha * alpha;
    float sine2 = clamp((pow(a, 1.0 - xi.x) - a) / (1.0 - a), 0.0, 1.0), angle = 2.0 * kPi * xi.y;
    return vec3(sqrt(sine2) * vec2(cos(angle), sin(angle)), sqrt(1.0 - sine2));
}
float gtr1_pdf(vec3 v, vec3 h, float alpha) {
    return gtr1(h, alpha) * h.z / max(4.0 * abs(dot(v, h)), 1e-6);
}

// --- Disney

struct Disney {
    vec2 alpha;       // of the specular lobe along x and y
    vec3 reflectance; // at normal incidence
    vec3 base;
    vec3 sheen;
    float coat;       // weight of the clear coat
    float coat_alpha;
};
Disney make_disney(IsoMaterial m) {
    Disney d;
    d.base = clamp(m.base_color, vec3(0.0), vec3(1.0));
    float luma = dot(d.base, vec3(0.3, 0.6, 0.1));
    vec3 tint = luma > 0.0 ? d.base / luma : vec3(1.0);
    vec3 dielectric = min(0.08 * m.specular * mix(vec3(1.0), tint, m.specular_tint), vec3(1.0));
    d.reflectance = mix(dielectric, d.base, m.metallic);
    d.sheen = (1.0 - m.metallic) * m.sheen * mix(vec3(1.0), tint, m.sheen_tint);
    d.base *= 1.0 - m.metallic;
    float aspect = sqrt(1.0 - 0.9 * m.anisotropic), alpha = m.roughness * m.roughness;
    d.alpha = max(vec2(alpha / aspect, alpha * aspect), vec2(0.001));
    d.coat = 0.25 * m.clearcoat;
    d.coat_alpha = mix(0.1, 0.001, m.clearcoat_gloss);
    return d;
}
/// No less than what the coat reflects from a direction; bounds of numerical integrals.
float coat_albedo(Disney d, float cosine) {
    float c = 1.0 - cosine;
    return d.coat * min(0.2, 0.04 + 0.3 * c * c * c);
}
/// No less than what the specular lobe reflects.
vec3 specular_albedo(Disney d, float cosine) {
    float r2 = min(d.alpha.x, d.alpha.y), c = 1.0 - cosine;
    float grazing = min(fifth_power(c) + 0.005, exp(-4.0 * r2 / (sqrt(r2) + 0.12)) * c);
    return mix(d.reflectance, vec3(1.0), grazing);
}
/// Chances of the lobes: cosine, specular, coat.
vec3 disney_chances(Disney d, vec3 v) {
    float coat = coat_albedo(d, v.z), specular = largest(specular_albedo(d, v.z)) + 0.01;
    vec3 c = vec3(largest(d.base) + 0.1 * largest(d.sheen), specular, coat);
    return c / (c.x + c.y + c.z);
}

vec3 evaluate_disney(IsoMaterial m, Disney d, vec3 v, vec3 l) {
    vec3 h = normalize(v + l);
    float l_h = dot(l, h), fresnel = schlick(l_h);
    float view = schlick(v.z), light = schlick(l.z);

    float retro = m.roughness * l_h * l_h;
    float diffuse = mix(1.0, 0.5 + 2.0 * retro, view) * mix(1.0, 0.5 + 2.0 * retro, light);
    float under = mix(1.0, retro, view) * mix(1.0, retro, light);
    float subsurface = 1.25 * (under * (1.0 / (l.z + v.z) - 0.5) + 0.5);
    vec3 body = mix(diffuse, subsurface, m.subsurface) * d.base / kPi + fresnel * d.sheen;
    body = min(body, (1.0 - max(specular_albedo(d, v.z), specular_albedo(d, l.z))) / kPi);

    float microfacets = ggx(h, d.alpha) * masking(v, d.alpha) * masking(l, d.alpha);
    vec3 specular = mix(d.reflectance, vec3(1.0), fresnel) * microfacets;
    float coat = d.coat * gtr1(h, d.coat_alpha) * mix(0.04, 1.0, fresnel) *
        masking(v, vec2(0.25)) * masking(l, vec2(0.25));
    float through = 1.0 - max(coat_albedo(d, v.z), coat_albedo(d, l.z));
    return (coat + through * (body + specular)) * l.z;
}
float disney_pdf(Disney d, vec3 v, vec3 l) {
    vec3 h = normalize(v + l);
    if (h.z < 0.0) h = -h;
    return dot(disney_chances(d, v), vec3(cosine_pdf(l), ggx_pdf(v, h, d.alpha), gtr1_pdf(v, h, d.coat_alpha)));
}

// --- The three models

/// Of v in the frame of the surface.
vec3 above_horizon(vec3 v) { return normalize(vec3(v.xy, max(v.z, 1e-3))); }

vec3 evaluate_local(IsoMaterial m, uint shading, vec3 v, vec3 l) {
    if (!(l.z > 0.0)) return vec3(0.0);
    if (shading == SHADING_DISNEY) return evaluate_disney(m, make_disney(m), v, l);
    vec3 body = clamp(m.base_color, vec3(0.0), vec3(1.0)) / kPi;
    if (shading == SHADING_PHONG) {
        float share = 0.08 * m.specular, exponent = phong_exponent(m.roughness);
        body = (1.0 - share) * body + share * (exponent + 2.0) * mirror_power(exponent, v, l);
    }
    return body * l.z;
}
float local_pdf(IsoMaterial m, uint shading, vec3 v, vec3 l) {
    if (shading == SHADING_DISNEY) return disney_pdf(make_disney(m), v, l);
    if (shading == SHADING_LAMBERT) return cosine_pdf(l);
    float share = 0.08 * m.specular, exponent = phong_exponent(m.roughness);
    return mix(cosine_pdf(l), (exponent + 1.0) * mirror_power(exponent, v, l), share);
}
vec3 sample_local(IsoMaterial m, uint shading, vec3 v, vec4 xi) {
    if (shading == SHADING_DISNEY) {
        Disney d = make_disney(m);
        vec3 chances = disney_chances(d, v);
        if (xi.z >= chances.x) {
            vec3 h = xi.z < chances.x + chances.y ? sample_ggx(v, d.alpha, xi.xy) : sample_gtr1(d.coat_alpha, xi.xy);
            return 2.0 * dot(v, h) * h - v;
        }
    } else if (shading == SHADING_PHONG && xi.z < 0.08 * m.specular) {
        return sample_mirror(phong_exponent(m.roughness), v, xi.xy);
    }
    return sample_cosine(xi.xy);
}

/// Share of even light that the diffuse part reflects.
vec3 iso_diffuse_albedo(IsoMaterial m, uint shading) {
    float diffuse = shading == SHADING_DISNEY ? 1.0 - m.metallic
        : shading == SHADING_PHONG            ? 1.0 - 0.08 * m.specular
                                              : 1.0;
    return diffuse * clamp(m.base_color, vec3(0.0), vec3(1.0));
}
/// BRDF times cos; 0 below the horizon. Reciprocal but for cos.
vec3 evaluate_iso(IsoMaterial m, uint shading, vec3 n, vec3 v, vec3 l) {
    mat3 to_world = shading_frame(n);
    return evaluate_local(m, shading, above_horizon(v * to_world), l * to_world);
}
/// Density of sample_iso over the sphere, integrates to 1; some of it may lie below the horizon.
float pdf_iso(IsoMaterial m, uint shading, vec3 n, vec3 v, vec3 l) {
    mat3 to_world = shading_frame(n);
    return local_pdf(m, shading, above_horizon(v * to_world), l * to_world);
}
/// A direction l, and BRDF * cos / pdf, 0 where l is below the horizon. xi: xy in (0, 1) for the
/// direction, z for the lobe.
vec3 sample_iso(IsoMaterial m, uint shading, vec3 n, vec3 v, vec4 xi, out vec3 l, out float pdf) {
    mat3 to_world = shading_frame(n);
    vec3 view = above_horizon(v * to_world);
    vec3 local = normalize(sample_local(m, shading, view, xi)); // drivers may err by 2^-11 in sin, cos
    pdf = local_pdf(m, shading, view, local);
    l = to_world * local;
    return pdf > 0.0 ? evaluate_local(m, shading, view, local) / pdf : vec3(0.0);
}

#endif

// SPDX-License-Identifier: Apache-2.0
// Metallic-roughness reflection: Lambert plus GGX with height-correlated Smith shadowing and
// Schlick's Fresnel. glTF 2.0 specification, appendix B; Heitz, JCGT 2014.

struct Surface {
    vec3 diffuse;     // diffuse albedo
    vec3 reflectance; // at normal incidence
    float alpha2;     // (roughness^2)^2
};

Surface make_surface(vec3 base_color, float metallic, float roughness, float reflectance) {
    Surface s;
    s.diffuse = base_color * (1.0 - metallic);
    s.reflectance = mix(vec3(reflectance), base_color, metallic);
    float alpha = max(roughness * roughness, 0.002);
    s.alpha2 = alpha * alpha;
    return s;
}

/// BRDF times the cosine at the light; n, v, l unit. Zero below the horizon.
vec3 reflect_light(Surface s, vec3 n, vec3 v, vec3 l) {
    float n_l = dot(n, l);
    if (n_l <= 0.0) return vec3(0.0);
    float n_v = max(abs(dot(n, v)), 1e-4);
    vec3 h = v + l;
    h *= inversesqrt(max(dot(h, h), 1e-12));
    float n_h = clamp(dot(n, h), 0.0, 1.0);
    float l_h = clamp(dot(l, h), 0.0, 1.0);
    float d = (n_h * s.alpha2 - n_h) * n_h + 1.0;
    float distribution = s.alpha2 / (3.14159265 * d * d);
    float shadow_v = n_l * sqrt((n_v - n_v * s.alpha2) * n_v + s.alpha2);
    float shadow_l = n_v * sqrt((n_l - n_l * s.alpha2) * n_l + s.alpha2);
    float visibility = 0.5 / (shadow_v + shadow_l);
    float c = 1.0 - l_h;
    float c2 = c * c;
    vec3 fresnel = s.reflectance + (1.0 - s.reflectance) * (c2 * c2 * c);
    return ((1.0 - fresnel) * s.diffuse * 0.318309886 + fresnel * (distribution * visibility)) * n_l;
}

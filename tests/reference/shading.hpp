// SPDX-License-Identifier: Apache-2.0
// Plain C++ twin of shaders/include/bsdf.glsl and of the lighting of shade_sample.glsl without
// textures and shadows, in double precision.
#pragma once

#include "framework/scene/scene.hpp"

#include <glm/glm.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ockham::reference {

/// Metallic-roughness BRDF of glTF 2.0, appendix B, times the cosine at the light.
inline glm::dvec3 reflect_light(
    const Material& material, glm::dvec3 base_color, glm::dvec3 n, glm::dvec3 v, glm::dvec3 l) {
    const double n_l = glm::dot(n, l), n_v = std::abs(glm::dot(n, v));
    if (n_l <= 0.0) return glm::dvec3(0.0);
    const glm::dvec3 h = glm::normalize(v + l);
    const double n_h = std::clamp(glm::dot(n, h), 0.0, 1.0);
    const double l_h = std::clamp(glm::dot(l, h), 0.0, 1.0);
    const double roughness = material.roughness;
    const double alpha = std::max(roughness * roughness, 0.002);
    const double alpha2 = alpha * alpha;
    const double d = n_h * n_h * (alpha2 - 1.0) + 1.0;
    const double distribution = alpha2 / (std::numbers::pi * d * d);
    // Height-correlated Smith, divided by 4 n_l n_v.
    const double lambda_v = n_l * std::sqrt(n_v * n_v * (1.0 - alpha2) + alpha2);
    const double lambda_l = n_v * std::sqrt(n_l * n_l * (1.0 - alpha2) + alpha2);
    const double visibility = 0.5 / (lambda_v + lambda_l);
    const double r = (material.ior - 1.0) / (material.ior + 1.0);
    const double metallic = material.metallic;
    const glm::dvec3 f0 = glm::mix(glm::dvec3(r * r), base_color, metallic);
    const glm::dvec3 fresnel = f0 + (1.0 - f0) * std::pow(1.0 - l_h, 5.0);
    const glm::dvec3 diffuse = base_color * (1.0 - metallic) / std::numbers::pi;
    return n_l * ((1.0 - fresnel) * diffuse + fresnel * distribution * visibility);
}

/// Irradiance-like factor of a light at a point and the direction towards it (scene/light.hpp).
struct Arriving {
    glm::dvec3 light;
    glm::dvec3 direction;
};
inline Arriving arriving(const Light& light, glm::dvec3 point) {
    const glm::dvec3 axis(light.direction);
    if (light.type == LightType::directional) return {glm::dvec3(light.intensity), -axis};
    const glm::dvec3 to_light = glm::dvec3(light.position) - point;
    const double distance = glm::length(to_light);
    const glm::dvec3 l = to_light / distance;
    const double window =
        std::isinf(light.range)
            ? 1.0
            : std::max(0.0, 1.0 - std::pow(distance / light.range, light.window_power));
    double factor = window / (distance * distance + light.softening);
    if (light.type == LightType::spot) {
        // KHR_lights_punctual: linear in the cosine between the cones, squared.
        const double scale = 1.0 / std::max(0.001, std::cos(double{light.inner_cone}) -
                                                       std::cos(double{light.outer_cone}));
        const double cone =
            std::clamp((glm::dot(-axis, l) - std::cos(double{light.outer_cone})) * scale, 0.0, 1.0);
        factor *= cone * cone;
    }
    return {glm::dvec3(light.intensity) * factor, l};
}

/// Radiance from `point` towards unit `v` under all lights of the scene.
inline glm::dvec3 radiance(const Scene& scene, const Material& material, glm::dvec3 base_color,
    glm::dvec3 n, glm::dvec3 point, glm::dvec3 v, double occlusion = 1.0) {
    if (material.unlit) return base_color;
    const double r = (material.ior - 1.0) / (material.ior + 1.0);
    const double metallic = material.metallic;
    const glm::dvec3 f0 = glm::mix(glm::dvec3(r * r), base_color, metallic);
    glm::dvec3 sum = glm::dvec3(material.emissive) +
                     glm::dvec3(scene.ambient) * occlusion * (base_color * (1.0 - metallic) + f0);
    for (const Light& light : scene.lights) {
        const Arriving a = arriving(light, point);
        sum += a.light * reflect_light(material, base_color, n, v, a.direction);
    }
    return sum;
}

} // namespace ockham::reference

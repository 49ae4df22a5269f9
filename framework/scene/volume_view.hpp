// SPDX-License-Identifier: Apache-2.0
// What is shown of a volume, and in what light, beside its transfer function: a plain struct that
// command lines and windows fill, and passes/volume/frame.hpp turns into the units of kernels.
#pragma once

#include "shaders/shared/volume.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <vector>

namespace ockham {

/// What is shown of a volume, and in what light. Values of the field are data values.
struct VolumeView {
    glm::vec3 light_direction{0.0f, 0.0f, -1.0f}; ///< the way that light travels; any length > 0
    glm::vec3 light_irradiance{0.0f};             ///< on a surface that faces it
    glm::vec3 environment{1.0f};                  ///< radiance; a map replaces it
    glm::vec3 crop_min{0.0f}, crop_max{1.0f};     ///< unit coordinates, min < max
    /// World; kept where dot(xyz, p) + w >= 0. At most MAX_CLIP_PLANES.
    std::vector<glm::vec4> clip_planes;

    float density_scale = 100.0f; ///< extinction per world unit where the opacity is 1, >= 0
    float albedo = 1.0f;          ///< times the transfer function's colour; [0, 1]
    float phase_g = 0.0f;         ///< (-1, 1)

    struct Surface {
        double value = 0; ///< isovalue
        float opacity = 1.0f;
        /// Burley's defaults.
        shader::IsoMaterial material{.base_color = glm::vec3(0.8f),
            .metallic = 0.0f,
            .subsurface = 0.0f,
            .specular = 0.5f,
            .roughness = 0.5f,
            .specular_tint = 0.0f,
            .anisotropic = 0.0f,
            .sheen = 0.0f,
            .sheen_tint = 0.5f,
            .clearcoat = 0.0f,
            .clearcoat_gloss = 1.0f};
    };
    std::vector<Surface> surfaces; ///< at most MAX_SURFACES
    std::uint32_t shading = SHADING_LAMBERT;
    float surface_gain = 1.0f, volume_gain = 1.0f;

    std::uint32_t seed = 1;
    std::uint32_t max_bounces = ~0u; ///< scatterings per path
};

} // namespace ockham

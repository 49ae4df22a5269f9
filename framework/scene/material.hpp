// SPDX-License-Identifier: Apache-2.0
// glTF 2 metallic-roughness materials and the decoded images they refer to.
#pragma once

#include <glm/glm.hpp>

#include <cstdint>
#include <string>
#include <vector>

namespace ockham {

/// A decoded 8-bit image, row 0 at v = 0 (top, as glTF). Colour images are sRGB-encoded, data
/// images (normals, roughness) linear: the material that uses an image decides.
struct TextureImage {
    std::string name;
    int width = 0;
    int height = 0;
    std::vector<std::uint8_t> rgba; ///< 4 * width * height bytes
};

enum class Wrap : std::uint32_t { repeat, clamp, mirror };

/// One use of an image by a material: which texture coordinates, moved how.
struct TextureUse {
    int image = -1; ///< index into Scene::images; -1 = none, the factor alone counts
    int uv_set = 0; ///< 0 or 1
    /// KHR_texture_transform as rows of a 2x3 matrix: uv' = M * (u, v, 1).
    glm::vec3 transform_u{1.0f, 0.0f, 0.0f};
    glm::vec3 transform_v{0.0f, 1.0f, 0.0f};
    Wrap wrap_u = Wrap::repeat;
    Wrap wrap_v = Wrap::repeat;

    bool used() const { return image >= 0; }
    /// Same coordinates (set, transform and wrap), whatever the image.
    bool same_coordinates(const TextureUse& other) const {
        return uv_set == other.uv_set && transform_u == other.transform_u &&
               transform_v == other.transform_v && wrap_u == other.wrap_u && wrap_v == other.wrap_v;
    }
};

struct Material {
    std::string name;
    glm::vec4 base_color{1.0f}; ///< linear; times the texture and the vertex colour
    TextureUse base_color_texture;
    float metallic = 1.0f;  ///< [0,1], times the texture's blue channel
    float roughness = 1.0f; ///< perceptual, [0,1], times the texture's green channel
    TextureUse metallic_roughness_texture;
    TextureUse normal_texture; ///< tangent space, green up (glTF)
    float normal_scale = 1.0f;
    TextureUse occlusion_texture; ///< red channel, dims ambient light only
    float occlusion_strength = 1.0f;
    glm::vec3 emissive{0.0f}; ///< radiance, KHR_materials_emissive_strength multiplied in
    TextureUse emissive_texture;
    float ior = 1.5f;    ///< KHR_materials_ior; normal-incidence reflectance of dielectrics
    bool masked = false; ///< alpha below `alpha_cutoff` is a hole
    float alpha_cutoff = 0.5f;
    bool double_sided = false;
    bool unlit = false; ///< KHR_materials_unlit: base colour is the radiance
};

} // namespace ockham

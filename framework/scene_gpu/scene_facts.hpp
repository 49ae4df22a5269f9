// SPDX-License-Identifier: Apache-2.0
// What a scene contains, as far as it decides which passes, resources and shader variants exist.
// Derived from the CPU scene alone; read by scene_gpu and by passes/pipelines.
#pragma once

#include "framework/scene/scene.hpp"

#include <cstddef>
#include <cstdint>

namespace ockham {

struct SceneFacts {
    std::uint64_t triangles = 0;
    bool color_textures = false;        ///< a used material has a base colour or emissive image
    bool shading_data_textures = false; ///< ... a metallic-roughness or occlusion image
    bool normal_maps = false;
    bool glossy = false; ///< a used material is somewhere smoother than roughness 1
    bool masked = false;
    bool masked_textures = false;    ///< a masked material takes its alpha from an image
    bool vertex_colors = false;      ///< a used primitive has colours
    bool second_coordinates = false; ///< a material's images need two different sets of coordinates
    std::size_t materials = 0;       ///< of the scene, used or not: ids of them are not made anew
    std::uint32_t directional_lights = 0;
    std::uint32_t point_lights = 0;
    std::uint32_t spot_lights = 0;
    bool sun_shadow = false; ///< the first directional light casts one, and there is geometry

    /// The G-buffer needs its second target.
    bool extra_target() const { return vertex_colors || second_coordinates; }
    bool data_textures() const { return shading_data_textures || normal_maps; }
    std::uint32_t lights() const { return directional_lights + point_lights + spot_lights; }
};

/// Only primitives that an instance shows count, and only materials that they use.
SceneFacts facts_of(const Scene& scene);

} // namespace ockham

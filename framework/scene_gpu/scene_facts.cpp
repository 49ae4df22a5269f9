// SPDX-License-Identifier: Apache-2.0
#include "framework/scene_gpu/scene_facts.hpp"

namespace ockham {

SceneFacts facts_of(const Scene& scene) {
    SceneFacts facts;
    facts.materials = scene.materials.size();
    for (const Instance& instance : scene.instances) {
        for (const Primitive& primitive :
            scene.meshes[static_cast<std::size_t>(instance.mesh)].primitives) {
            if (primitive.indices.empty()) continue;
            const Material& material =
                scene.materials[static_cast<std::size_t>(primitive.material)];
            facts.triangles += primitive.triangles();
            facts.vertex_colors |= !primitive.colors.empty();
            facts.masked |= material.masked;
            facts.masked_textures |= material.masked && material.base_color_texture.used();
            facts.normal_maps |= material.normal_texture.used();
            facts.glossy |= material.roughness < 1.0f || material.metallic_roughness_texture.used();
            facts.color_textures |=
                material.base_color_texture.used() || material.emissive_texture.used();
            facts.shading_data_textures |=
                material.metallic_roughness_texture.used() || material.occlusion_texture.used();
            const TextureUse* first = nullptr;
            for (const TextureUse* use : {&material.base_color_texture, &material.emissive_texture,
                     &material.metallic_roughness_texture, &material.occlusion_texture}) {
                if (!use->used()) continue;
                if (first == nullptr) first = use;
                facts.second_coordinates |= !use->same_coordinates(*first);
            }
        }
    }
    for (const Light& light : scene.lights) {
        if (light.type == LightType::directional) {
            if (facts.directional_lights++ == 0)
                facts.sun_shadow = light.casts_shadow && facts.triangles > 0;
        } else if (light.type == LightType::point) {
            ++facts.point_lights;
        } else {
            ++facts.spot_lights;
        }
    }
    return facts;
}

} // namespace ockham

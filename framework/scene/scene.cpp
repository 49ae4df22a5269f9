// SPDX-License-Identifier: Apache-2.0
#include "framework/scene/scene.hpp"

#include <cmath>
#include <iterator>
#include <utility>

namespace ockham {
namespace {

template <class T>
void move_append(std::vector<T>& to, std::vector<T>& from) {
    to.insert(to.end(), std::make_move_iterator(from.begin()), std::make_move_iterator(from.end()));
}

void shift_image(TextureUse& use, int offset) {
    if (use.used()) use.image += offset;
}

} // namespace

std::size_t Scene::triangles() const {
    std::size_t count = 0;
    for (const Instance& instance : instances) {
        for (const Primitive& primitive : meshes.at(instance.mesh).primitives) {
            count += primitive.triangles();
        }
    }
    return count;
}

Bounds Scene::bounds() const {
    Bounds result;
    for (const Instance& instance : instances) {
        for (const Primitive& primitive : meshes.at(instance.mesh).primitives) {
            for (const glm::vec3& position : primitive.positions) {
                result.add(glm::vec3(instance.world * glm::vec4(position, 1.0f)));
            }
        }
    }
    return result;
}

void append(Scene& scene, Scene addition) {
    const auto first_mesh = static_cast<int>(scene.meshes.size());
    const auto first_material = static_cast<int>(scene.materials.size());
    const auto first_image = static_cast<int>(scene.images.size());
    for (Instance& instance : addition.instances) instance.mesh += first_mesh;
    for (Mesh& mesh : addition.meshes) {
        for (Primitive& primitive : mesh.primitives) primitive.material += first_material;
    }
    for (Material& material : addition.materials) {
        shift_image(material.base_color_texture, first_image);
        shift_image(material.metallic_roughness_texture, first_image);
        shift_image(material.normal_texture, first_image);
        shift_image(material.occlusion_texture, first_image);
        shift_image(material.emissive_texture, first_image);
    }
    move_append(scene.meshes, addition.meshes);
    move_append(scene.instances, addition.instances);
    move_append(scene.materials, addition.materials);
    move_append(scene.images, addition.images);
    move_append(scene.lights, addition.lights);
    move_append(scene.cameras, addition.cameras);
    if (scene.name.empty()) scene.name = std::move(addition.name);
    if (scene.background == glm::vec3(0.0f)) scene.background = addition.background;
    if (scene.ambient == glm::vec3(0.0f)) scene.ambient = addition.ambient;
}

Camera default_camera(const Bounds& bounds, UpAxis up) {
    constexpr float kFovYDegrees = 60.0f;
    constexpr float kMargin = 1.05f;
    const float radius = bounds.radius() > 0.0f ? bounds.radius() : 1.0f;
    // The sphere around the box touches the sides of the view cone at this distance.
    const float distance = kMargin * radius / std::sin(glm::radians(0.5f * kFovYDegrees));
    const glm::vec3 toward_viewer = glm::normalize(
        up == UpAxis::y ? glm::vec3(0.0f, 0.25f, 1.0f) : glm::vec3(0.0f, -1.0f, 0.25f));
    return look_at(bounds.center() + distance * toward_viewer, bounds.center(), kFovYDegrees, up);
}

} // namespace ockham

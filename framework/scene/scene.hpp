// SPDX-License-Identifier: Apache-2.0
// A world on the CPU: meshes placed by instances, materials, images, lights, cameras. Filled by
// io/gltf and scene/builtin, uploaded by scene_gpu. Never changed while it is being rendered.
#pragma once

#include "framework/scene/camera.hpp"
#include "framework/scene/light.hpp"
#include "framework/scene/material.hpp"
#include "framework/scene/mesh.hpp"

#include <string>
#include <vector>

namespace ockham {

struct Instance {
    int mesh = 0; ///< index into Scene::meshes
    glm::mat4 world{1.0f};
};

struct Scene {
    std::string name;
    std::vector<Mesh> meshes;
    std::vector<Instance> instances;
    std::vector<Material> materials;
    std::vector<TextureImage> images;
    std::vector<Light> lights;
    std::vector<Camera> cameras;
    glm::vec3 background{0.0f}; ///< radiance where no surface is hit
    glm::vec3 ambient{0.0f};    ///< radiance that every surface receives from everywhere

    /// Triangles over all instances.
    std::size_t triangles() const;
    /// World-space box of all instances; empty without geometry.
    Bounds bounds() const;
};

/// Puts `addition` into `scene`: all arrays are appended and indices shifted. Background and
/// ambient are kept, unless `scene` has none.
void append(Scene& scene, Scene addition);

/// A camera that sees the whole of `bounds` from its front, slightly above. The front is +z, or -y
/// where z is up.
Camera default_camera(const Bounds& bounds, UpAxis up = UpAxis::y);

} // namespace ockham

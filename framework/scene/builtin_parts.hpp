// SPDX-License-Identifier: Apache-2.0
// What the built-in scenes share: putting images, materials, meshes and lights into a Scene. Not a
// public interface; included by builtin*.cpp only.
#pragma once

#include "framework/core/rng.hpp"
#include "framework/scene/builtin_textures.hpp"
#include "framework/scene/scene.hpp"
#include "framework/scene/shapes.hpp"

#include <string>
#include <vector>

namespace ockham {

// Scenes with files of their own; see docs/builtin_scenes.md.
Scene builtin_atrium();
Scene builtin_foliage();
Scene builtin_sparkle();

/// Each returns the index of what it added.
int add_image(Scene& scene, TextureImage image);
/// Dielectric of one colour.
int add_material(Scene& scene, std::string name, glm::vec3 base_color, float roughness);
/// Dielectric with the images that `images` has.
int add_material(Scene& scene, std::string name, SurfaceImages images, float roughness);
int add_mesh(Scene& scene, std::string name, std::vector<Primitive> primitives);
int add_mesh(Scene& scene, std::string name, Shape& shape);

void add_instance(Scene& scene, int mesh, const glm::mat4& world = glm::mat4(1.0f));

/// Shadowed sun; `toward` points to it, any length > 0.
void add_sun(Scene& scene, glm::vec3 toward, glm::vec3 irradiance);
void add_camera(
    Scene& scene, std::string name, glm::vec3 position, glm::vec3 target, float fov_y_degrees);

/// A leaf card: a square of twig texture, bent downwards, from `base` along `along`, its face
/// towards `face`.
void add_sprig(Shape& shape, glm::dvec3 base, glm::dvec3 along, glm::dvec3 face, double size);
/// Unit, uniform over the sphere.
glm::dvec3 random_direction(Pcg32& rng);

} // namespace ockham

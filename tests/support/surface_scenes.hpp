// SPDX-License-Identifier: Apache-2.0
// Small scenes in code for tests of the surface passes, and cameras under which one world unit is
// one pixel. Not for pictures that people look at: see scene/builtin.
#pragma once

#include "framework/scene/scene.hpp"

#include <functional>

namespace ockham::test {

/// Rectangle with corners `corner`, `corner + across`, `corner + across + up`, `corner + up`; its
/// front looks along cross(across, up). uv is (0,1) at `corner`, (1,0) diagonally opposite, times
/// `uv_scale`; tangents along `across`.
Primitive rectangle(glm::vec3 corner, glm::vec3 across, glm::vec3 up, int material = 0,
    glm::vec2 uv_scale = glm::vec2(1.0f));
/// One triangle, flat normal, no texture coordinates.
Primitive triangle(glm::vec3 a, glm::vec3 b, glm::vec3 c, int material = 0);

/// Adds a mesh of one primitive and an instance of it.
void add(Scene& scene, Primitive primitive, const glm::mat4& world = glm::mat4(1.0f));

/// Unlit, white: the base colour is the radiance.
Material unlit_material(glm::vec3 color = glm::vec3(1.0f));

/// Adds an image whose texel (x, y) is `texel` in RGBA bytes; returns its index.
int add_image(
    Scene& scene, int width, int height, const std::function<glm::u8vec4(int x, int y)>& texel);

/// Orthographic camera in front of the xy plane: pixel (x, y) of a picture `height` pixels high
/// shows world [x, x+1] x [height-1-y, height-y], seen along -z from z = 100.
Camera pixel_camera(std::uint32_t width, std::uint32_t height);

/// A little of everything: tilted textured planes, a bumpy normal map, MASK leaves, a mirrored
/// instance, vertex colours, thin bars, point, spot and directional lights, sky. Fits the view of
/// its camera.
Scene varied_scene(bool with_shadow = false);

} // namespace ockham::test

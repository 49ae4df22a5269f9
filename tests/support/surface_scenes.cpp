// SPDX-License-Identifier: Apache-2.0
#include "tests/support/surface_scenes.hpp"

#include <glm/gtc/matrix_transform.hpp>

#include <cmath>

namespace ockham::test {

Primitive rectangle(
    glm::vec3 corner, glm::vec3 across, glm::vec3 up, int material, glm::vec2 uv_scale) {
    Primitive p;
    p.positions = {corner, corner + across, corner + across + up, corner + up};
    p.normals.assign(4, glm::normalize(glm::cross(across, up)));
    p.tangents.assign(4, glm::vec4(glm::normalize(across), 1.0f));
    p.uvs[0] = {uv_scale * glm::vec2(0, 1), uv_scale, uv_scale * glm::vec2(1, 0), glm::vec2(0)};
    p.indices = {0, 1, 2, 0, 2, 3};
    p.material = material;
    return p;
}

Primitive triangle(glm::vec3 a, glm::vec3 b, glm::vec3 c, int material) {
    Primitive p;
    p.positions = {a, b, c};
    p.normals.assign(3, glm::normalize(glm::cross(b - a, c - a)));
    p.indices = {0, 1, 2};
    p.material = material;
    return p;
}

void add(Scene& scene, Primitive primitive, const glm::mat4& world) {
    scene.instances.push_back({static_cast<int>(scene.meshes.size()), world});
    scene.meshes.push_back({"mesh", {std::move(primitive)}});
}

Material unlit_material(glm::vec3 color) {
    Material material;
    material.base_color = glm::vec4(color, 1.0f);
    material.unlit = true;
    return material;
}

int add_image(
    Scene& scene, int width, int height, const std::function<glm::u8vec4(int x, int y)>& texel) {
    TextureImage image{"image", width, height, {}};
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const glm::u8vec4 t = texel(x, y);
            image.rgba.insert(image.rgba.end(), {t.r, t.g, t.b, t.a});
        }
    }
    scene.images.push_back(std::move(image));
    return static_cast<int>(scene.images.size()) - 1;
}

Camera pixel_camera(std::uint32_t width, std::uint32_t height) {
    Camera camera;
    camera.position = {0.5f * static_cast<float>(width), 0.5f * static_cast<float>(height), 100.0f};
    camera.orthographic_height = static_cast<float>(height);
    return camera;
}

Scene varied_scene(bool with_shadow) {
    Scene scene;
    scene.name = "varied";
    scene.background = {0.2f, 0.3f, 0.5f};
    scene.ambient = glm::vec3(0.05f);
    const int checker = add_image(scene, 16, 16, [](int x, int y) {
        return (x / 4 + y / 4) % 2 ? glm::u8vec4(230, 200, 90, 255) : glm::u8vec4(40, 60, 120, 255);
    });
    const int bumps = add_image(scene, 32, 24, [](int x, int y) {
        const double a = 0.8 * std::sin(0.6 * x), b = 0.8 * std::cos(0.5 * y);
        const double length = std::sqrt(a * a + b * b + 1.0);
        const auto byte = [&](double v) {
            return static_cast<unsigned char>(127.5 * (v / length + 1.0) + 0.5);
        };
        return glm::u8vec4(byte(a), byte(b), byte(1.0), 255);
    });
    const int leaf = add_image(scene, 32, 32, [](int x, int y) {
        const int dx = x % 16 - 8, dy = y % 16 - 8;
        const int alpha = std::clamp(255 - 4 * (dx * dx + dy * dy), 0, 255);
        return glm::u8vec4(60, 160, 50, alpha);
    });
    const int rough = add_image(scene, 8, 8,
        [](int x, int y) { return glm::u8vec4(40 + 25 * y, 60 + 20 * x, (x + y) % 3 * 100, 255); });

    Material floor;
    floor.base_color_texture.image = checker;
    floor.metallic = 0.0f;
    floor.roughness = 0.6f;
    Material bumpy;
    bumpy.base_color = {0.7f, 0.5f, 0.4f, 1.0f};
    bumpy.normal_texture.image = bumps;
    bumpy.metallic_roughness_texture.image = rough;
    bumpy.occlusion_texture.image = rough;
    bumpy.occlusion_texture.transform_u = {2.0f, 0.0f, 0.0f};
    Material leaves;
    leaves.base_color_texture.image = leaf;
    leaves.masked = true;
    leaves.double_sided = true;
    leaves.metallic = 0.0f;
    Material glow;
    glow.emissive = {3.0f, 1.5f, 0.5f};
    glow.roughness = 0.3f;
    scene.materials = {floor, bumpy, leaves, glow};

    add(scene, rectangle({-6, 0, 2}, {12, 0, 0}, {0, 0, -20}, 0, {6, 10}));
    add(scene, rectangle({-5, 0, -6}, {5, 0, -2}, {0, 4, 0}, 1, {2, 1.5f}));
    add(scene, rectangle({0.3f, 0.2f, -1}, {2, 0, 0.5f}, {0.2f, 2, 0}, 2));
    Primitive colored = rectangle({2, 0, -5}, {3, 0, 1}, {0, 3, 0}, 3);
    colored.colors = {{1, 0.2f, 0.2f, 1}, {0.2f, 1, 0.2f, 1}, {0.2f, 0.2f, 1, 1}, {1, 1, 1, 1}};
    add(scene, std::move(colored));
    for (int i = 0; i < 12; ++i) { // bars thinner than a sample, turning
        const float t = 0.26f * static_cast<float>(i);
        add(scene, rectangle({-2.0f + t, 0.1f, -0.5f}, {0.01f, 0, 0.001f}, {0.1f * t, 1.6f, 0}, 3));
    }
    const glm::mat4 mirror = glm::scale(glm::mat4(1.0f), glm::vec3(-1, 1, 1));
    add(scene, rectangle({3, 0.5f, -2}, {1.2f, 0, 0}, {0, 1.2f, -0.4f}, 0), mirror);

    Light sun;
    sun.type = LightType::directional;
    sun.direction = glm::normalize(glm::vec3(0.4f, -1.0f, -0.5f));
    sun.intensity = {2.5f, 2.3f, 2.0f};
    sun.casts_shadow = with_shadow;
    Light lamp;
    lamp.position = {-2, 2, 0};
    lamp.intensity = glm::vec3(4.0f);
    lamp.softening = 0.1f;
    lamp.range = 8.0f;
    lamp.window_power = 2.0f;
    Light spot;
    spot.type = LightType::spot;
    spot.position = {2, 3, 0};
    spot.direction = glm::normalize(glm::vec3(-0.2f, -1, -0.6f));
    spot.intensity = {2, 6, 9};
    spot.inner_cone = 0.3f;
    spot.outer_cone = 0.5f;
    scene.lights = {sun, lamp, spot};
    scene.cameras = {look_at({0, 1.4f, 4}, {0, 1.0f, -2}, 60.0f)};
    return scene;
}

} // namespace ockham::test

// SPDX-License-Identifier: Apache-2.0
#include "framework/scene/scene.hpp"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include <cmath>

namespace ockham {
namespace {

/// One triangle, placed twice: as it is, and moved by (10, 0, 0).
Scene two_triangles() {
    Scene scene;
    scene.name = "two";
    Primitive primitive;
    primitive.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, -1}};
    primitive.indices = {0, 1, 2};
    scene.meshes.push_back({"triangle", {primitive}});
    scene.instances.push_back({0, glm::mat4(1.0f)});
    scene.instances.push_back({0, glm::translate(glm::mat4(1.0f), glm::vec3(10, 0, 0))});
    scene.materials.resize(1);
    scene.materials[0].base_color_texture.image = 0;
    scene.images.resize(1);
    scene.lights.resize(1);
    scene.cameras.resize(1);
    return scene;
}

TEST(Scene, CountsAndBoundsItsInstances) {
    const Scene scene = two_triangles();
    EXPECT_EQ(scene.triangles(), 2u);
    EXPECT_EQ(scene.bounds().low, glm::vec3(0, 0, -1));
    EXPECT_EQ(scene.bounds().high, glm::vec3(11, 1, 0));
}

TEST(Scene, EmptyHasNoBounds) {
    const Scene scene;
    EXPECT_EQ(scene.triangles(), 0u);
    EXPECT_TRUE(scene.bounds().empty());
}

TEST(Append, ShiftsEveryIndex) {
    Scene scene = two_triangles();
    Scene addition = two_triangles();
    addition.materials[0].normal_texture.image = 0;
    append(scene, addition);
    EXPECT_EQ(scene.triangles(), 4u);
    ASSERT_EQ(scene.instances.size(), 4u);
    EXPECT_EQ(scene.instances[1].mesh, 0);
    EXPECT_EQ(scene.instances[3].mesh, 1);
    EXPECT_EQ(scene.meshes[0].primitives[0].material, 0);
    EXPECT_EQ(scene.meshes[1].primitives[0].material, 1);
    EXPECT_EQ(scene.materials[0].base_color_texture.image, 0);
    EXPECT_EQ(scene.materials[1].base_color_texture.image, 1);
    EXPECT_EQ(scene.materials[1].normal_texture.image, 1);
    EXPECT_EQ(scene.materials[1].emissive_texture.image, -1) << "none stays none";
    EXPECT_EQ(scene.images.size(), 2u);
    EXPECT_EQ(scene.lights.size(), 2u);
    EXPECT_EQ(scene.cameras.size(), 2u);
    EXPECT_EQ(scene.name, "two");
}

TEST(Append, KeepsBackgroundAndAmbientUnlessThereAreNone) {
    Scene scene, addition;
    addition.background = glm::vec3(1, 2, 3);
    addition.ambient = glm::vec3(4, 5, 6);
    scene.ambient = glm::vec3(0.5f);
    append(scene, addition);
    EXPECT_EQ(scene.background, glm::vec3(1, 2, 3));
    EXPECT_EQ(scene.ambient, glm::vec3(0.5f));
}

TEST(LookAt, AxesAreUnitAndPerpendicular) {
    const Camera camera = look_at({1, 2, 3}, {-4, 0, 7}, 50.0f);
    EXPECT_EQ(camera.position, glm::vec3(1, 2, 3));
    EXPECT_EQ(camera.fov_y_degrees, 50.0f);
    EXPECT_NEAR(glm::length(camera.forward), 1.0f, 1e-6f);
    EXPECT_NEAR(glm::length(camera.up), 1.0f, 1e-6f);
    EXPECT_NEAR(glm::dot(camera.forward, camera.up), 0.0f, 1e-6f);
    EXPECT_GT(camera.up.y, 0.0f);
    EXPECT_EQ(look_at({0, 0, 5}, {0, 0, 0}, 60.0f).up, glm::vec3(0, 1, 0));
}

TEST(LookAt, UpIsZWhereTheViewRunsAlongY) {
    EXPECT_EQ(look_at({0, 5, 0}, {0, 0, 0}, 60.0f).up, glm::vec3(0, 0, 1));
    EXPECT_EQ(look_at({0, 0, 0}, {0, 5, 0}, 60.0f).up, glm::vec3(0, 0, 1));
}

TEST(LookAt, UpMayBeZ) {
    const Camera camera = look_at({0, -5, 0}, {0, 0, 0}, 60.0f, UpAxis::z);
    EXPECT_EQ(camera.up, glm::vec3(0, 0, 1));
    EXPECT_EQ(look_at({0, 0, 5}, {0, 0, 0}, 60.0f, UpAxis::z).up, glm::vec3(0, 1, 0));
}

TEST(Turned, CarriesTheCameraAroundTheCentre) {
    const Camera camera = look_at({1, -4, 2}, {1, 2, 0}, 60.0f, UpAxis::z);
    const Camera quarter = turned(camera, {1, 2, 0}, UpAxis::z, glm::radians(90.0f));
    EXPECT_LT(glm::distance(quarter.position, glm::vec3(7, 2, 2)), 1e-5f) << "from front to right";
    const Camera expected = look_at({7, 2, 2}, {1, 2, 0}, 60.0f, UpAxis::z);
    EXPECT_LT(glm::distance(quarter.forward, expected.forward), 1e-6f);
    EXPECT_LT(glm::distance(quarter.up, expected.up), 1e-6f);
}

TEST(DefaultCamera, LooksFromMinusYWhereZIsUp) {
    Bounds bounds;
    bounds.add({-1, -1, -1});
    bounds.add({1, 1, 1});
    const Camera camera = default_camera(bounds, UpAxis::z);
    EXPECT_LT(camera.position.y, -1.0f);
    EXPECT_GT(camera.position.z, 0.0f);
    EXPECT_GT(camera.up.z, 0.9f);
}

TEST(DefaultCamera, SeesAllCornersOfTheBox) {
    Bounds bounds;
    bounds.add({-3, 1, 4});
    bounds.add({5, 2, 40});
    const Camera camera = default_camera(bounds);
    const glm::vec3 right = glm::cross(camera.forward, camera.up);
    const float slope = std::tan(glm::radians(0.5f * camera.fov_y_degrees));
    for (int corner = 0; corner < 8; ++corner) {
        const glm::vec3 point(corner & 1 ? 5 : -3, corner & 2 ? 2 : 1, corner & 4 ? 40 : 4);
        const glm::vec3 seen = point - camera.position;
        const float depth = glm::dot(seen, camera.forward);
        ASSERT_GT(depth, 0.0f);
        EXPECT_LT(std::abs(glm::dot(seen, camera.up)) / depth, slope);
        EXPECT_LT(std::abs(glm::dot(seen, right)) / depth, slope);
    }
    EXPECT_GT(camera.position.z, 40.0f) << "in front";
    EXPECT_GT(camera.position.y, 2.0f) << "above";
}

TEST(DefaultCamera, OfAnEmptyOrPointLikeSceneIsFinite) {
    Bounds point;
    point.add({7, 7, 7});
    for (const Bounds& bounds : {Bounds{}, point}) {
        const Camera camera = default_camera(bounds);
        EXPECT_NEAR(glm::length(camera.forward), 1.0f, 1e-6f);
        EXPECT_GT(glm::length(camera.position - bounds.center()), 0.5f);
    }
}

} // namespace
} // namespace ockham

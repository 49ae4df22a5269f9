// SPDX-License-Identifier: Apache-2.0
// What a scene is said to contain, on hand-made scenes: only what an instance shows counts.
#include "framework/scene_gpu/scene_facts.hpp"

#include <gtest/gtest.h>

namespace ockham {
namespace {

/// One triangle, one material, one instance.
Scene triangle_scene() {
    Scene scene;
    Primitive p;
    p.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    p.normals.assign(3, {0, 0, 1});
    p.indices = {0, 1, 2};
    scene.materials.resize(1);
    scene.meshes = {{"mesh", {p}}};
    scene.instances = {{0, glm::mat4(1.0f)}};
    scene.images.push_back({"image", 1, 1, {255, 255, 255, 255}});
    return scene;
}

TEST(SceneFacts, NothingOfNothing) {
    const SceneFacts facts = facts_of({});
    EXPECT_EQ(facts.triangles, 0u);
    EXPECT_FALSE(facts.color_textures || facts.data_textures() || facts.masked ||
                 facts.extra_target() || facts.sun_shadow);
    EXPECT_EQ(facts.directional_lights + facts.point_lights + facts.spot_lights, 0u);
}

TEST(SceneFacts, PlainTriangleNeedsNothing) {
    Scene scene = triangle_scene();
    scene.instances.push_back({0, glm::mat4(2.0f)});
    const SceneFacts facts = facts_of(scene);
    EXPECT_EQ(facts.triangles, 2u) << "instances count";
    EXPECT_FALSE(
        facts.color_textures || facts.data_textures() || facts.masked || facts.extra_target());
}

TEST(SceneFacts, EachImageCountsForItsArray) {
    const auto facts_with = [](TextureUse Material::*use) {
        Scene scene = triangle_scene();
        (scene.materials[0].*use).image = 0;
        return facts_of(scene);
    };
    for (const auto use : {&Material::base_color_texture, &Material::emissive_texture}) {
        EXPECT_TRUE(facts_with(use).color_textures);
        EXPECT_FALSE(facts_with(use).data_textures());
    }
    for (const auto use : {&Material::metallic_roughness_texture, &Material::occlusion_texture}) {
        EXPECT_TRUE(facts_with(use).shading_data_textures);
        EXPECT_FALSE(facts_with(use).color_textures);
        EXPECT_FALSE(facts_with(use).normal_maps);
    }
    const SceneFacts bumpy = facts_with(&Material::normal_texture);
    EXPECT_TRUE(bumpy.normal_maps && bumpy.data_textures());
    EXPECT_FALSE(bumpy.shading_data_textures) << "shading reads none: the G-buffer does";
}

TEST(SceneFacts, WhatNoInstanceShowsDoesNotCount) {
    Scene scene = triangle_scene();
    Material rich;
    rich.base_color_texture.image = rich.normal_texture.image = 0;
    rich.masked = true;
    scene.materials.push_back(rich);
    EXPECT_FALSE(facts_of(scene).color_textures) << "material without a primitive";
    scene.meshes.push_back(scene.meshes[0]);
    scene.meshes[1].primitives[0].material = 1;
    scene.meshes[1].primitives[0].colors.assign(3, glm::vec4(1.0f));
    EXPECT_FALSE(facts_of(scene).color_textures) << "mesh without an instance";
    EXPECT_FALSE(facts_of(scene).vertex_colors);
    scene.instances.push_back({1, glm::mat4(1.0f)});
    const SceneFacts facts = facts_of(scene);
    EXPECT_TRUE(facts.color_textures && facts.normal_maps && facts.masked &&
                facts.masked_textures && facts.vertex_colors && facts.extra_target());
    scene.meshes[1].primitives[0].indices.clear();
    EXPECT_FALSE(facts_of(scene).color_textures) << "primitive without triangles";
}

TEST(SceneFacts, MaskByFactorNeedsNoImage) {
    Scene scene = triangle_scene();
    scene.materials[0].masked = true;
    EXPECT_TRUE(facts_of(scene).masked);
    EXPECT_FALSE(facts_of(scene).masked_textures);
    scene.materials[0].emissive_texture.image = 0;
    EXPECT_FALSE(facts_of(scene).masked_textures) << "emission has no alpha";
}

TEST(SceneFacts, TwoSetsOfCoordinatesNeedTheSecondTarget) {
    Scene scene = triangle_scene();
    Material& material = scene.materials[0];
    material.base_color_texture.image = material.emissive_texture.image = 0;
    EXPECT_FALSE(facts_of(scene).extra_target()) << "both alike";
    material.normal_texture.image = 0;
    material.normal_texture.uv_set = 1;
    EXPECT_FALSE(facts_of(scene).extra_target()) << "the normal map is done by then";
    material.emissive_texture.uv_set = 1;
    EXPECT_TRUE(facts_of(scene).second_coordinates);
    material.emissive_texture.uv_set = 0;
    material.emissive_texture.transform_u = {2, 0, 0};
    EXPECT_TRUE(facts_of(scene).extra_target());
    material.emissive_texture.transform_u = {1, 0, 0};
    material.emissive_texture.wrap_v = Wrap::mirror;
    EXPECT_TRUE(facts_of(scene).extra_target());
    material.emissive_texture.image = -1;
    EXPECT_FALSE(facts_of(scene).extra_target()) << "unused";
}

TEST(SceneFacts, GlossIsAnythingSmootherThanRoughnessOne) {
    Scene scene = triangle_scene();
    EXPECT_FALSE(facts_of(scene).glossy);
    scene.materials[0].roughness = 0.99f;
    EXPECT_TRUE(facts_of(scene).glossy);
    scene.materials[0].roughness = 1;
    scene.materials[0].metallic_roughness_texture.image = 0;
    EXPECT_TRUE(facts_of(scene).glossy) << "its texels may be smaller";
}

TEST(SceneFacts, LightsByTypeAndTheSunsShadow) {
    Scene scene = triangle_scene();
    scene.lights.resize(7);
    for (const std::size_t i : {1u, 4u}) scene.lights[i].type = LightType::directional;
    scene.lights[5].type = LightType::spot;
    SceneFacts facts = facts_of(scene);
    EXPECT_EQ(facts.directional_lights, 2u);
    EXPECT_EQ(facts.point_lights, 4u);
    EXPECT_EQ(facts.spot_lights, 1u);
    EXPECT_FALSE(facts.sun_shadow);
    scene.lights[4].casts_shadow = true;
    EXPECT_FALSE(facts_of(scene).sun_shadow) << "only the first directional light may";
    scene.lights[0].casts_shadow = true;
    EXPECT_FALSE(facts_of(scene).sun_shadow) << "a point light";
    scene.lights[1].casts_shadow = true;
    EXPECT_TRUE(facts_of(scene).sun_shadow);
    scene.instances.clear();
    EXPECT_FALSE(facts_of(scene).sun_shadow) << "nothing to throw one";
}

} // namespace
} // namespace ockham

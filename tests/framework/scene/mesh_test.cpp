// SPDX-License-Identifier: Apache-2.0
#include "framework/scene/mesh.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace ockham {
namespace {

/// Two triangles in the plane z = 0, counter-clockwise from +z; u runs along +x, v down.
Primitive quad() {
    Primitive primitive;
    primitive.positions = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}};
    primitive.uvs[0] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    primitive.indices = {0, 1, 2, 0, 2, 3};
    primitive.normals.assign(4, {0, 0, 1});
    return primitive;
}

void expect_near(glm::vec3 a, glm::vec3 b) {
    EXPECT_LT(glm::length(a - b), 1e-6f) << a.x << " " << a.y << " " << a.z;
}

TEST(FlatNormals, EachTriangleHasItsOwnVerticesAndNormal) {
    Primitive primitive = quad();
    primitive.positions[3] = {0, 0, 2}; // folds the second triangle about the diagonal
    primitive.colors.assign(4, glm::vec4(0.5f));
    primitive.colors[3].r = 0.25f;
    generate_flat_normals(primitive);
    ASSERT_EQ(primitive.positions.size(), 6u);
    ASSERT_EQ(primitive.normals.size(), 6u);
    ASSERT_EQ(primitive.uvs[0].size(), 6u);
    ASSERT_EQ(primitive.colors.size(), 6u);
    EXPECT_EQ(primitive.indices, (std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5}));
    EXPECT_EQ(primitive.colors[5].r, 0.25f);
    EXPECT_EQ(primitive.uvs[0][4], glm::vec2(1, 0));
    const float half = std::sqrt(0.5f);
    for (int i = 0; i < 3; ++i) {
        expect_near(primitive.normals[i], {0, 0, 1});
        expect_near(primitive.normals[3 + i], {half, -half, 0});
    }
}

TEST(FlatNormals, TriangleWithoutAreaGetsAUnitNormal) {
    Primitive primitive = quad();
    primitive.positions.assign(4, {1, 1, 1});
    generate_flat_normals(primitive);
    for (const glm::vec3& normal : primitive.normals) EXPECT_EQ(glm::length(normal), 1.0f);
}

TEST(FlatNormals, SmallAndLargeTrianglesKeepTheirDirection) {
    for (const float scale : {1e-25f, 1e-10f, 1e15f, 1e30f}) {
        Primitive primitive = quad();
        for (glm::vec3& position : primitive.positions) position *= scale;
        generate_flat_normals(primitive);
        for (const glm::vec3& normal : primitive.normals) expect_near(normal, {0, 0, 1});
    }
}

TEST(Tangents, FollowUAndTheBitangentPointsUp) {
    Primitive primitive = quad();
    generate_tangents(primitive, 0);
    ASSERT_EQ(primitive.tangents.size(), 4u);
    for (const glm::vec4& tangent : primitive.tangents) {
        expect_near(glm::vec3(tangent), {1, 0, 0});
        EXPECT_EQ(tangent.w, 1.0f);
        const glm::vec3 bitangent = glm::cross(glm::vec3(0, 0, 1), glm::vec3(tangent)) * tangent.w;
        expect_near(bitangent, {0, 1, 0}); // against v, which runs down
    }
}

TEST(Tangents, MirroredCoordinatesHaveNegativeSign) {
    Primitive primitive = quad();
    for (glm::vec2& uv : primitive.uvs[0]) uv.x = -uv.x;
    generate_tangents(primitive, 0);
    for (const glm::vec4& tangent : primitive.tangents) {
        expect_near(glm::vec3(tangent), {-1, 0, 0});
        EXPECT_EQ(tangent.w, -1.0f);
    }
}

TEST(Tangents, VerticesBetweenBothSignsAreSplit) {
    Primitive primitive = quad();
    primitive.uvs[0][3] = {2, 1}; // mirrors the second triangle
    generate_tangents(primitive, 0);
    ASSERT_EQ(primitive.positions.size(), 6u) << "vertices 0 and 2 are shared by both signs";
    ASSERT_EQ(primitive.indices.size(), 6u);
    for (int i = 0; i < 3; ++i) {
        EXPECT_EQ(primitive.tangents[primitive.indices[i]].w, 1.0f);
        EXPECT_EQ(primitive.tangents[primitive.indices[3 + i]].w, -1.0f);
    }
    EXPECT_EQ(primitive.positions[primitive.indices[3]], glm::vec3(0, 0, 0));
    EXPECT_EQ(primitive.positions[primitive.indices[4]], glm::vec3(2, 2, 0));
    EXPECT_EQ(primitive.positions[primitive.indices[5]], glm::vec3(0, 2, 0));
}

TEST(Tangents, DegenerateCoordinatesGiveAnyPerpendicularUnitVector) {
    Primitive primitive = quad();
    primitive.uvs[0].assign(4, {0.5f, 0.5f});
    generate_tangents(primitive, 0);
    ASSERT_EQ(primitive.tangents.size(), 4u);
    for (const glm::vec4& tangent : primitive.tangents) {
        EXPECT_NEAR(glm::length(glm::vec3(tangent)), 1.0f, 1e-6f);
        EXPECT_NEAR(tangent.z, 0.0f, 1e-6f);
        EXPECT_EQ(std::abs(tangent.w), 1.0f);
    }
}

TEST(Tangents, UseTheGivenSet) {
    Primitive primitive = quad();
    primitive.uvs[1] = {{0, 0}, {0, 1}, {1, 1}, {1, 0}}; // u runs along +y
    generate_tangents(primitive, 1);
    for (const glm::vec4& tangent : primitive.tangents) expect_near(glm::vec3(tangent), {0, 1, 0});
}

TEST(Tangents, DoNotDependOnTheScaleOfTheCoordinates) {
    for (const float scale : {1e-12f, 1e12f}) {
        Primitive primitive = quad();
        for (glm::vec2& uv : primitive.uvs[0]) uv *= scale;
        generate_tangents(primitive, 0);
        for (const glm::vec4& tangent : primitive.tangents)
            expect_near(glm::vec3(tangent), {1, 0, 0});
    }
}

TEST(RepairNormals, NormalisesAndReplacesThoseWithoutDirection) {
    Primitive primitive = quad();
    primitive.normals = {{0, 0, 5}, {0, 0, 0}, {NAN, 0, 0}, {0, 1e-30f, 0}};
    EXPECT_EQ(repair_normals(primitive), 2u);
    expect_near(primitive.normals[0], {0, 0, 1});
    expect_near(primitive.normals[1], {0, 0, 1});
    expect_near(primitive.normals[2], {0, 0, 1});
    expect_near(primitive.normals[3], {0, 1, 0});
}

TEST(DropDegenerateTriangles, KeepsTheOthersInOrder) {
    Primitive primitive = quad();
    primitive.indices = {0, 0, 1, 0, 1, 2, 1, 2, 4, 3, 1, 3, 0, 2, 3, 2, 1, 1};
    EXPECT_EQ(drop_degenerate_triangles(primitive), 4u);
    EXPECT_EQ(primitive.indices, (std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3}));
    EXPECT_EQ(drop_degenerate_triangles(primitive), 0u);
}

TEST(DropUnusedVertices, RenamesTheOthers) {
    Primitive primitive = quad();
    primitive.indices = {3, 1, 2};
    EXPECT_EQ(drop_unused_vertices(primitive), 1u);
    EXPECT_EQ(primitive.positions, (std::vector<glm::vec3>{{2, 0, 0}, {2, 2, 0}, {0, 2, 0}}));
    EXPECT_EQ(primitive.indices, (std::vector<std::uint32_t>{2, 0, 1}));
    EXPECT_EQ(primitive.uvs[0].size(), 3u);
    EXPECT_EQ(drop_unused_vertices(primitive), 0u);
}

TEST(Bounds, EmptyUntilAPointIsAdded) {
    Bounds bounds;
    EXPECT_TRUE(bounds.empty());
    EXPECT_EQ(bounds.radius(), 0.0f);
    EXPECT_EQ(bounds.center(), glm::vec3(0.0f));
    bounds.add({1, 2, 3});
    EXPECT_FALSE(bounds.empty());
    EXPECT_EQ(bounds.center(), glm::vec3(1, 2, 3));
}

} // namespace
} // namespace ockham

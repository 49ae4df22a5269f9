// SPDX-License-Identifier: Apache-2.0
// Rays through the tree of a scene's triangles meet what a search of all of them meets.
#include "framework/scene/builtin.hpp"
#include "framework/scene/mesh_tree.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

namespace ockham::test {
namespace {

constexpr float kNothing = std::numeric_limits<float>::infinity();

Material matte(const glm::vec4& color) {
    Material material;
    material.base_color = color;
    material.metallic = 0;
    material.ior = 1;
    return material;
}

/// One primitive of these triangles, with an instance.
void add(Scene& scene, std::vector<glm::vec3> corners, const glm::mat4& world = glm::mat4(1.0f),
    int material = 0) {
    Primitive primitive;
    primitive.material = material;
    primitive.positions = std::move(corners);
    for (std::uint32_t i = 0; i < primitive.positions.size(); ++i) primitive.indices.push_back(i);
    scene.instances.push_back({static_cast<int>(scene.meshes.size()), world});
    scene.meshes.push_back({"", {std::move(primitive)}});
}

/// Where a ray meets a triangle, in double precision.
float meet(const shader::MeshTriangle& t, const glm::vec3& origin, const glm::vec3& direction) {
    const glm::dvec3 d(direction), across(t.across), up(t.up), p = glm::cross(d, up);
    const double determinant = glm::dot(across, p);
    const glm::dvec3 s = glm::dvec3(origin) - glm::dvec3(t.corner), q = glm::cross(s, across);
    const double u = glm::dot(s, p) / determinant, v = glm::dot(d, q) / determinant,
                 along = glm::dot(up, q) / determinant;
    return u >= 0 && v >= 0 && u + v <= 1 && along > 0 ? static_cast<float>(along) : kNothing;
}

float meet_any(const MeshTree& tree, const glm::vec3& origin, const glm::vec3& direction) {
    float t = kNothing;
    for (const shader::MeshTriangle& triangle : tree.triangles)
        t = std::min(t, meet(triangle, origin, direction));
    return t;
}

struct Walk {
    float t = kNothing;
    int nodes = 0; ///< looked at
};

/// As shaders/volume/mesh_tree.glsl walks.
Walk walk(const MeshTree& tree, const glm::vec3& origin, const glm::vec3& direction) {
    Walk out;
    std::uint32_t octant = 0;
    for (int axis = 0; axis < 3; ++axis) octant |= direction[axis] < 0 ? 1u << axis : 0u;
    for (std::uint32_t row = tree.nodes.empty() ? MESH_END : 0; row != MESH_END; ++out.nodes) {
        const shader::MeshNode& node = tree.nodes[row / MESH_NODE_ROWS];
        const glm::vec3 a = (node.low - origin) / direction, b = (node.high - origin) / direction;
        const glm::vec3 enter = glm::min(a, b), leave = glm::max(a, b);
        const float near = std::max({enter.x, enter.y, enter.z, 0.0f});
        const float far = std::min({leave.x, leave.y, leave.z, out.t});
        row = node.next[octant];
        if (!(near <= far * 1.000001f)) continue;
        if (node.kind < 4) {
            row = node.first + MESH_NODE_ROWS * (octant >> node.kind & 1);
            continue;
        }
        for (std::uint32_t i = 0; i < node.kind / 4; ++i) {
            const std::size_t first = node.first - MESH_NODE_ROWS * tree.nodes.size();
            out.t = std::min(
                out.t, meet(tree.triangles[first / MESH_TRIANGLE_ROWS + i], origin, direction));
        }
    }
    return out;
}

/// Mean number of nodes per ray; expects every ray to meet what all triangles say.
double compare(const MeshTree& tree, const Bounds& bounds, int rays, bool expect_hits = true) {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
    int met = 0;
    std::int64_t nodes = 0;
    for (int i = 0; i < rays; ++i) {
        const glm::vec3 origin =
            bounds.center() +
            1.5f * bounds.radius() * glm::vec3(unit(random), unit(random), unit(random));
        const glm::vec3 target =
            bounds.center() +
            0.5f * (bounds.high - bounds.low) * glm::vec3(unit(random), unit(random), unit(random));
        const glm::vec3 direction = glm::normalize(target - origin);
        const Walk found = walk(tree, origin, direction);
        EXPECT_EQ(found.t, meet_any(tree, origin, direction)) << i;
        met += found.t < kNothing ? 1 : 0;
        nodes += found.nodes;
    }
    EXPECT_EQ(met > rays / 10, expect_hits);
    return static_cast<double>(nodes) / rays;
}

TEST(MeshTreeTest, FindsWhatASearchOfAllTrianglesFinds) {
    Scene scene;
    scene.materials = {matte(glm::vec4(1.0f))};
    std::mt19937 random(3);
    std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
    const auto place = [&](float size) {
        return size * glm::vec3(unit(random), unit(random), unit(random));
    };
    std::vector<glm::vec3> corners;
    for (int i = 0; i < 2000; ++i) { // small ones, and some that reach far
        const glm::vec3 at = place(10.0f);
        for (int c = 0; c < 3; ++c) corners.push_back(at + place(i % 50 == 0 ? 8.0f : 0.3f));
    }
    add(scene, corners);
    add(scene, corners, glm::mat4(0.5f)); // mat4(0.5) halves w as well: the same places
    const MeshTree tree = build_mesh_tree(scene);
    EXPECT_EQ(tree.triangles.size(), 4000u);
    EXPECT_LT(compare(tree, scene.bounds(), 2000), 300); // of some 4000 nodes
}

TEST(MeshTreeTest, WalksThroughTheAtriumAreShort) {
    const Scene scene = builtin_scene("atrium");
    const MeshTree tree = build_mesh_tree(scene);
    EXPECT_GT(tree.triangles.size(), 10000u);
    EXPECT_LT(compare(tree, scene.bounds(), 60), 150);
    EXPECT_LT(tree.bytes(), 130 * tree.triangles.size());
}

TEST(MeshTreeTest, LeavesHoldAllTrianglesOnceAndNodesAllBelow) {
    const Scene scene = builtin_scene("atrium");
    const MeshTree tree = build_mesh_tree(scene);
    const std::size_t rows = MESH_NODE_ROWS * tree.nodes.size();
    std::size_t held = 0;
    for (const shader::MeshNode& node : tree.nodes) {
        if (node.kind < 4) {
            for (std::size_t i = 0; i < 2; ++i) {
                const shader::MeshNode& child = tree.nodes[node.first / MESH_NODE_ROWS + i];
                EXPECT_EQ(glm::min(node.low, child.low), node.low);
                EXPECT_EQ(glm::max(node.high, child.high), node.high);
            }
            continue;
        }
        EXPECT_LE(node.kind / 4, MESH_LEAF);
        EXPECT_EQ(node.first, rows + MESH_TRIANGLE_ROWS * held); // in the order of the nodes
        held += node.kind / 4;
    }
    EXPECT_EQ(held, tree.triangles.size());
}

TEST(MeshTreeTest, DegenerateTrianglesAreLeftOutAndEqualOnesDivided) {
    EXPECT_TRUE(build_mesh_tree({}).nodes.empty());
    Scene scene;
    scene.materials = {matte(glm::vec4(1.0f))};
    const glm::vec3 a(0, 0, 0), b(1, 0, 0), c(0, 1, 0);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    add(scene, {a, a, b, a, b, 2.0f * b, a, b, glm::vec3(nan)});
    EXPECT_TRUE(build_mesh_tree(scene).nodes.empty());
    for (int i = 0; i < 50; ++i) add(scene, {a, b, c});
    const MeshTree tree = build_mesh_tree(scene);
    EXPECT_EQ(tree.triangles.size(), 50u);
    EXPECT_EQ(walk(tree, {0.2f, 0.2f, 3}, {0, 0, -1}).t, 3.0f);
    EXPECT_EQ(walk(tree, {0.7f, 0.7f, 3}, {0, 0, -1}).t, kNothing);
}

TEST(MeshTreeTest, TheSameSceneGivesTheSameTree) {
    const Scene scene = builtin_scene("atrium");
    const MeshTree one = build_mesh_tree(scene), two = build_mesh_tree(scene);
    ASSERT_EQ(one.bytes(), two.bytes());
    EXPECT_EQ(std::memcmp(
                  one.nodes.data(), two.nodes.data(), one.nodes.size() * sizeof(shader::MeshNode)),
        0);
    EXPECT_EQ(std::memcmp(one.triangles.data(), two.triangles.data(),
                  one.triangles.size() * sizeof(shader::MeshTriangle)),
        0);
}

TEST(MeshTreeTest, TrianglesHaveTheLookOfTheirMaterial) {
    Scene scene;
    scene.images = {{"halves", 2, 1, {255, 255, 255, 255, 0, 0, 0, 0}}}; // white, and a hole
    scene.materials.assign(4, matte({1.0f, 0.5f, 0.25f, 1.0f}));
    scene.materials[1].unlit = true;
    scene.materials[2].emissive = {3, 0.5f, 1000};
    scene.materials[2].ior = 1.5f;
    scene.materials[3].base_color_texture.image = 0;
    scene.materials[3].base_color_texture.wrap_u = Wrap::clamp;
    scene.materials[3].masked = true;
    for (int i = 0; i < 4; ++i) add(scene, {{0, 0, i}, {1, 0, i}, {0, 1, i}}, glm::mat4(1.0f), i);
    scene.meshes[3].primitives[0].uvs[0] = {{0, 0}, {1, 0}, {0, 1}};
    const auto look = [&](float z) {
        const MeshTree tree = build_mesh_tree(scene);
        for (const shader::MeshTriangle& t : tree.triangles)
            if (t.corner.z == z) return glm::uvec2(t.albedo, t.emitted);
        return glm::uvec2(0);
    };
    const auto emitted = [](std::uint32_t word) {
        const double scale = std::ldexp(1.0, static_cast<int>(word >> 27) - 24);
        return glm::dvec3(word & 511, word >> 9 & 511, word >> 18 & 511) * scale;
    };
    EXPECT_EQ(look(0).x, 0xff4080ffu);
    EXPECT_EQ(emitted(look(0).y), glm::dvec3(0.0));
    EXPECT_EQ(look(1).x, 0xff000000u);
    EXPECT_EQ(emitted(look(1).y), glm::dvec3(1.0, 0.5, 0.25));
    EXPECT_EQ(look(2).x, 0xff4a8affu); // 0.04 more, and no more than 1
    EXPECT_NEAR(emitted(look(2).y).z, 1000, 1);
    // Three quarters of it are nearer to u = 0 than to 1; what is left is all white.
    EXPECT_EQ(look(3).x & 0xffffffu, 0x4080ffu);
    EXPECT_NEAR((look(3).x >> 24) / 255.0, 0.75, 0.003);
    scene.materials[3].base_color.a = 0.1f;
    EXPECT_EQ(look(3), glm::uvec2(0)); // nothing but holes
}

} // namespace
} // namespace ockham::test

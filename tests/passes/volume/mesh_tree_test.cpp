// SPDX-License-Identifier: Apache-2.0
// shaders/volume/mesh_tree.glsl against a search of all triangles in double precision.
#include "framework/runtime/commands.hpp"
#include "framework/scene/mesh_tree.hpp"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/pass_bench.hpp"
#include "tests/support/surface_scenes.hpp"
#include "tests/support/z_test.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <random>

namespace ockham::test {
namespace {

struct Hit {
    std::uint32_t t, triangle, calls;
};

class MeshSearchTest : public GpuTest {
protected:
    static std::vector<Hit> find(const MeshTree& tree, const std::vector<glm::vec3>& rays) {
        PassBench bench(device());
        std::vector<std::byte> bytes(tree.bytes());
        const std::size_t nodes = tree.nodes.size() * sizeof(shader::MeshNode);
        std::memcpy(bytes.data(), tree.nodes.data(), nodes);
        std::memcpy(bytes.data() + nodes, tree.triangles.data(), bytes.size() - nodes);
        const BufferHandle rows = bench.buffer("mesh_tree", bytes);
        const BufferHandle given = bench.buffer("rays", rays);
        const auto count = static_cast<std::uint32_t>(rays.size() / 2);
        BufferHandle hits = bench.graph.create_buffer("hits", {count * sizeof(Hit)});
        PassBuilder pass = bench.graph.add_compute_pass("mesh_search");
        pass.read("mesh_tree", rows).read("mesh_links", rows).read("rays", given);
        hits = pass.write("hits", hits);
        pass.record([count](Commands& commands) {
            commands.dispatch_over({.shader = "test/mesh_search.comp"}, {count, 1, 1});
        });
        bench.graph.export_resource(hits, "test");
        bench.execute();
        return bench.read<Hit>(hits);
    }
};

/// How clearly a ray meets a triangle: least of the barycentric coordinates; `t`: where it would.
double clearance(const shader::MeshTriangle& t, const glm::vec3& origin, const glm::vec3& direction,
    double& along) {
    const glm::dvec3 d(direction), across(t.across), up(t.up), p = glm::cross(d, up);
    const double determinant = glm::dot(across, p);
    const glm::dvec3 s = glm::dvec3(origin) - glm::dvec3(t.corner), q = glm::cross(s, across);
    const double u = glm::dot(s, p) / determinant, v = glm::dot(d, q) / determinant;
    along = glm::dot(up, q) / determinant;
    return std::min({u, v, 1 - u - v});
}

TEST_F(MeshSearchTest, FindsWhatASearchOfAllTrianglesFinds) {
    Scene scene;
    scene.materials = {{}};
    std::mt19937 random(5);
    std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
    const auto place = [&](float size) {
        return size * glm::vec3(unit(random), unit(random), unit(random));
    };
    for (int i = 0; i < 1500; ++i) { // small ones, some that reach far, some in planes of the axes
        const glm::vec3 at = place(5.0f);
        glm::vec3 corners[3];
        for (glm::vec3& corner : corners) corner = at + place(i % 40 == 0 ? 6.0f : 0.3f);
        if (i % 3 == 0)
            for (glm::vec3& corner : corners) corner[i / 3 % 3] = std::round(at[i / 3 % 3]);
        add(scene, triangle(corners[0], corners[1], corners[2]));
    }
    const MeshTree tree = build_mesh_tree(scene);
    std::vector<glm::vec3> rays;
    for (int i = 0; i < 4000; ++i) {
        glm::vec3 direction = place(1.0f);
        if (i % 10 == 0) direction[i / 10 % 3] = 0.0f; // along a plane of the axes
        if (i % 50 == 0) direction = glm::vec3(i % 100 == 0 ? -1.0f : 1.0f, 0.0f, 0.0f);
        rays.push_back(place(6.0f));
        rays.push_back(glm::normalize(direction));
    }
    const std::vector<Hit> hits = find(tree, rays);
    std::size_t met = 0;
    for (std::size_t i = 0; i < hits.size(); ++i) {
        // The nearest triangle that is met clearly; those whose edge is close may be met as well.
        double nearest = 1e30;
        for (const shader::MeshTriangle& t : tree.triangles) {
            double along;
            if (clearance(t, rays[2 * i], rays[2 * i + 1], along) > 1e-4 && along > 1e-4)
                nearest = std::min(nearest, along);
        }
        const double found = std::bit_cast<float>(hits[i].t);
        EXPECT_LT(found, nearest * (1 + 1e-4) + 1e-3) << i;
        met += nearest < 1e30 ? 1u : 0u;
        if (hits[i].triangle == MESH_END) {
            EXPECT_EQ(found, double{1e30f});
            continue;
        }
        const std::size_t row = hits[i].triangle - MESH_NODE_ROWS * tree.nodes.size();
        double along;
        EXPECT_GT(clearance(tree.triangles.at(row / MESH_TRIANGLE_ROWS), rays[2 * i],
                      rays[2 * i + 1], along),
            -1e-4)
            << i;
        EXPECT_NEAR(found, along, 1e-3 * std::max(along, 1.0)) << i;
        EXPECT_LT(hits[i].calls, 60u);
    }
    EXPECT_GT(met, hits.size() / 4);
}

TEST_F(MeshSearchTest, HolesLetTheirShareOfRaysThrough) {
    Scene scene;
    add_image(scene, 2, 1, [](int x, int) { return glm::u8vec4(255, 255, 255, x == 0 ? 255 : 0); });
    Material leaf;
    leaf.base_color_texture.image = 0;
    leaf.base_color_texture.wrap_u = Wrap::clamp;
    leaf.masked = true;
    scene.materials = {leaf};
    add(scene, rectangle({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}));
    const MeshTree tree = build_mesh_tree(scene);
    ASSERT_EQ(tree.triangles.size(), 2u);
    std::vector<glm::vec3> rays;
    for (float x = -127; x < 128; x += 2) // even over the square
        for (float y = -127; y < 128; y += 2) {
            rays.emplace_back(x / 128, y / 128, 3.0f);
            rays.emplace_back(0, 0, -1);
        }
    double met = 0;
    for (const Hit& hit : find(tree, rays)) met += hit.triangle != MESH_END ? 1 : 0;
    const double n = 128 * 128; // half of it, of which each triangle has a share of its own
    EXPECT_LT(z_of({met / n, 0.5 / std::sqrt(n)}, 0.5), z_limit(1));
}

} // namespace
} // namespace ockham::test

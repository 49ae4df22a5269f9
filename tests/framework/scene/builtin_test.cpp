// SPDX-License-Identifier: Apache-2.0
#include "framework/core/error.hpp"
#include "framework/scene/builtin.hpp"
#include "framework/scene/shapes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <map>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace ockham {
namespace {

/// FNV-1a over everything in a scene that a picture depends on.
class SceneHash {
public:
    explicit SceneHash(const Scene& scene) {
        for (const Mesh& mesh : scene.meshes)
            for (const Primitive& primitive : mesh.primitives) add(primitive);
        for (const Instance& instance : scene.instances) {
            add(instance.mesh);
            for (int column = 0; column < 4; ++column) add(instance.world[column]);
        }
        for (const Material& material : scene.materials) add(material);
        for (const TextureImage& image : scene.images) {
            add(image.width), add(image.height);
            for (const std::uint8_t byte : image.rgba) add_byte(byte);
        }
        for (const Light& light : scene.lights) add(light);
        for (const Camera& camera : scene.cameras) {
            add(camera.position), add(camera.forward), add(camera.up);
            add(camera.fov_y_degrees), add(camera.orthographic_height);
        }
        add(scene.background), add(scene.ambient);
    }
    std::uint64_t value() const { return value_; }

private:
    void add_byte(std::uint8_t byte) { value_ = (value_ ^ byte) * 0x100000001b3ull; }
    void add(std::uint32_t word) {
        for (int shift = 0; shift < 32; shift += 8)
            add_byte(static_cast<std::uint8_t>(word >> shift));
    }
    void add(int value) { add(static_cast<std::uint32_t>(value)); }
    void add(bool value) { add_byte(value ? 1 : 0); }
    void add(float value) { add(std::bit_cast<std::uint32_t>(value)); }
    template <int N>
    void add(const glm::vec<N, float>& value) {
        for (int i = 0; i < N; ++i) add(value[i]);
    }
    template <class T>
    void add(const std::vector<T>& values) {
        for (const T& value : values) add(value);
    }
    void add(const Primitive& p) {
        add(p.positions), add(p.normals), add(p.tangents), add(p.uvs[0]), add(p.uvs[1]);
        add(p.colors), add(p.indices), add(p.material);
    }
    void add(const TextureUse& use) {
        add(use.image), add(use.uv_set), add(use.transform_u), add(use.transform_v);
        add(static_cast<std::uint32_t>(use.wrap_u)), add(static_cast<std::uint32_t>(use.wrap_v));
    }
    void add(const Material& m) {
        add(m.base_color), add(m.base_color_texture), add(m.metallic), add(m.roughness);
        add(m.metallic_roughness_texture), add(m.normal_texture), add(m.normal_scale);
        add(m.occlusion_texture), add(m.occlusion_strength), add(m.emissive);
        add(m.emissive_texture), add(m.ior), add(m.masked), add(m.alpha_cutoff);
        add(m.double_sided), add(m.unlit);
    }
    void add(const Light& light) {
        add(static_cast<std::uint32_t>(light.type)), add(light.position), add(light.direction);
        add(light.intensity), add(light.range), add(light.window_power), add(light.softening);
        add(light.inner_cone), add(light.outer_cone), add(light.casts_shadow);
    }

    std::uint64_t value_ = 0xcbf29ce484222325ull;
};

class EveryBuiltinScene : public testing::TestWithParam<std::string> {
protected:
    const Scene scene = builtin_scene(GetParam());

    /// Calls visit(primitive, name of its mesh) for every primitive.
    template <class Visit>
    void each_primitive(Visit&& visit) const {
        for (const Mesh& mesh : scene.meshes)
            for (const Primitive& primitive : mesh.primitives) visit(primitive, mesh.name);
    }
};

std::vector<std::string> scene_names() {
    std::vector<std::string> names;
    for (const BuiltinName& scene : builtin_scenes()) names.emplace_back(scene.name);
    return names;
}

INSTANTIATE_TEST_SUITE_P(Builtin, EveryBuiltinScene, testing::ValuesIn(scene_names()),
    [](const auto& test) { return test.param; });

TEST_P(EveryBuiltinScene, HasItsPinnedBits) {
    const std::map<std::string, std::uint64_t> pinned{
        {"atrium", 0x739b28810b040db8ull},
        {"fence", 0xc1b9496c40c11976ull},
        {"wires", 0x70b983de8eb95c82ull},
        {"sparkle", 0xb4ec63a65483c2f3ull},
        {"foliage", 0x8cbc5afd06cb5a35ull},
        {"plane", 0x8cd57eb0469cb578ull},
        {"sky", 0xa37ebd6a1334ce37ull},
    };
    const std::uint64_t hash = SceneHash(scene).value();
    EXPECT_EQ(hash, pinned.at(GetParam())) << fmt::format("found {:#018x}", hash);
    EXPECT_EQ(hash, SceneHash(builtin_scene(GetParam())).value());
}

TEST_P(EveryBuiltinScene, RefersOnlyToWhatItHas) {
    EXPECT_EQ(scene.name, GetParam());
    for (const Instance& instance : scene.instances)
        ASSERT_LT(std::size_t(instance.mesh), scene.meshes.size());
    for (const Material& material : scene.materials)
        for (const TextureUse* use :
            {&material.base_color_texture, &material.metallic_roughness_texture,
                &material.normal_texture, &material.occlusion_texture, &material.emissive_texture})
            ASSERT_LT(use->image, static_cast<int>(scene.images.size())) << material.name;
    for (const TextureImage& image : scene.images)
        ASSERT_EQ(image.rgba.size(), std::size_t(4) * image.width * image.height) << image.name;
    each_primitive([&](const Primitive& p, const std::string& mesh) {
        ASSERT_LT(std::size_t(p.material), scene.materials.size()) << mesh;
        ASSERT_EQ(p.normals.size(), p.positions.size()) << mesh;
        ASSERT_EQ(p.tangents.size(), p.positions.size()) << mesh;
        ASSERT_EQ(p.uvs[0].size(), p.positions.size()) << mesh;
        ASSERT_EQ(p.indices.size() % 3, 0u) << mesh;
        ASSERT_FALSE(p.indices.empty()) << mesh;
        for (const std::uint32_t index : p.indices) ASSERT_LT(index, p.positions.size()) << mesh;
    });
}

TEST_P(EveryBuiltinScene, HasUnitNormalsAndPerpendicularTangents) {
    each_primitive([&](const Primitive& p, const std::string& mesh) {
        for (std::size_t i = 0; i < p.positions.size(); ++i) {
            const glm::vec3 tangent(p.tangents[i]);
            ASSERT_NEAR(glm::length(p.normals[i]), 1.0f, 1e-6f) << mesh;
            ASSERT_NEAR(glm::length(tangent), 1.0f, 1e-6f) << mesh;
            ASSERT_NEAR(glm::dot(p.normals[i], tangent), 0.0f, 1e-6f) << mesh;
            ASSERT_EQ(std::abs(p.tangents[i].w), 1.0f) << mesh;
        }
    });
}

TEST_P(EveryBuiltinScene, WindsItsTrianglesLikeTheirNormals) {
    each_primitive([&](const Primitive& p, const std::string& mesh) {
        for (std::size_t i = 0; i < p.indices.size(); i += 3) {
            const glm::dvec3 a = p.positions[p.indices[i]];
            const glm::dvec3 cross = glm::cross(glm::dvec3(p.positions[p.indices[i + 1]]) - a,
                glm::dvec3(p.positions[p.indices[i + 2]]) - a);
            ASSERT_GT(glm::length(cross), 1e-9) << mesh << " triangle " << i / 3;
            for (int corner = 0; corner < 3; ++corner)
                ASSERT_GT(glm::dot(cross, glm::dvec3(p.normals[p.indices[i + corner]])), 0.0)
                    << mesh << " triangle " << i / 3;
        }
    });
}

// glTF: green of a normal map points up in the image, against v; so must w * cross(n, t).
TEST_P(EveryBuiltinScene, HasTangentsThatFollowTheTexture) {
    each_primitive([&](const Primitive& p, const std::string& mesh) {
        for (std::size_t i = 0; i < p.indices.size(); i += 3) {
            const std::uint32_t* id = &p.indices[i];
            const glm::dvec3 e1 = glm::dvec3(p.positions[id[1]]) - glm::dvec3(p.positions[id[0]]);
            const glm::dvec3 e2 = glm::dvec3(p.positions[id[2]]) - glm::dvec3(p.positions[id[0]]);
            const glm::dvec2 d1 = p.uvs[0][id[1]] - p.uvs[0][id[0]];
            const glm::dvec2 d2 = p.uvs[0][id[2]] - p.uvs[0][id[0]];
            const double area = d1.x * d2.y - d2.x * d1.y;
            ASSERT_NE(area, 0.0) << mesh << " triangle " << i / 3;
            const glm::dvec3 along_u = (e1 * d2.y - e2 * d1.y) / area;
            const glm::dvec3 along_v = (e2 * d1.x - e1 * d2.x) / area;
            const glm::dvec3 normal(p.normals[id[0]]);
            const glm::dvec3 tangent(p.tangents[id[0]]);
            ASSERT_GT(glm::dot(along_u, tangent), 0.0) << mesh << " triangle " << i / 3;
            ASSERT_LT(
                glm::dot(along_v, glm::cross(normal, tangent) * double(p.tangents[id[0]].w)), 0.0)
                << mesh << " triangle " << i / 3;
        }
    });
}

/// A triangle in the world, and its outline in the two axes that span its plane best.
struct PlacedTriangle {
    std::array<glm::dvec3, 3> corners;
    std::array<glm::dvec2, 3> outline{};
    std::string mesh;
};

/// Whether two outlines share more than a border of `margin` metres: no side of either separates
/// them.
bool overlap(const PlacedTriangle& a, const PlacedTriangle& b, double margin) {
    for (const auto& [first, second] : {std::pair{&a, &b}, std::pair{&b, &a}})
        for (int side = 0; side < 3; ++side) {
            const glm::dvec2 begin = first->outline[side];
            const glm::dvec2 edge = first->outline[(side + 1) % 3] - begin;
            glm::dvec2 outward = glm::normalize(glm::dvec2(edge.y, -edge.x));
            if (glm::dot(outward, first->outline[(side + 2) % 3] - begin) > 0.0) outward = -outward;
            double nearest = 1e9;
            for (const glm::dvec2& corner : second->outline)
                nearest = std::min(nearest, glm::dot(outward, corner - begin));
            if (nearest > -margin) return false;
        }
    return true;
}

// Surfaces in one plane fight for depth, whichever way they face. Leaf cards are left out: they
// lie at random.
TEST_P(EveryBuiltinScene, HasNoCoplanarOverlaps) {
    constexpr double kApart = 1e-4;  // metres between planes that count as one
    constexpr double kMargin = 1e-3; // metres that neighbours may share
    std::map<std::array<std::int64_t, 4>, std::vector<PlacedTriangle>> planes;
    for (const Instance& instance : scene.instances) {
        const Mesh& mesh = scene.meshes[instance.mesh];
        for (const Primitive& p : mesh.primitives) {
            if (scene.materials[p.material].masked) continue;
            for (std::size_t i = 0; i < p.indices.size(); i += 3) {
                PlacedTriangle triangle{.corners = {}, .mesh = mesh.name};
                for (int corner = 0; corner < 3; ++corner)
                    triangle.corners[corner] = glm::dvec3(
                        instance.world * glm::vec4(p.positions[p.indices[i + corner]], 1.0f));
                const auto& c = triangle.corners;
                const glm::dvec3 exact = glm::normalize(glm::cross(c[1] - c[0], c[2] - c[0]));
                glm::dvec3 normal = glm::round(exact * 500.0); // one plane, one projection
                const glm::dvec3 size = glm::abs(normal);
                const int drop = size.x > size.y && size.x > size.z ? 0 : size.y > size.z ? 1 : 2;
                const double sign = normal[drop] < 0.0 ? -1.0 : 1.0;
                normal *= sign;
                for (int corner = 0; corner < 3; ++corner)
                    triangle.outline[corner] = {
                        c[corner][(drop + 1) % 3], c[corner][(drop + 2) % 3]};
                planes[{std::llround(normal.x), std::llround(normal.y), std::llround(normal.z),
                           std::llround(sign * glm::dot(exact, c[0]) * 2000)}]
                    .push_back(std::move(triangle));
            }
        }
    }
    for (auto& [plane, triangles] : planes) {
        const auto left = [](const PlacedTriangle& t) {
            return std::min({t.outline[0].x, t.outline[1].x, t.outline[2].x});
        };
        std::sort(triangles.begin(), triangles.end(),
            [&](const auto& a, const auto& b) { return left(a) < left(b); });
        for (std::size_t i = 0; i < triangles.size(); ++i) {
            const PlacedTriangle& a = triangles[i];
            const double right = std::max({a.outline[0].x, a.outline[1].x, a.outline[2].x});
            const glm::dvec3 normal = glm::normalize(
                glm::cross(a.corners[1] - a.corners[0], a.corners[2] - a.corners[0]));
            for (std::size_t j = i + 1; j < triangles.size() && left(triangles[j]) < right; ++j) {
                const PlacedTriangle& b = triangles[j];
                if (std::abs(glm::dot(normal, b.corners[0] - a.corners[0])) > kApart) continue;
                ASSERT_FALSE(overlap(a, b, kMargin))
                    << a.mesh << " and " << b.mesh << " at " << a.corners[0].x << ", "
                    << a.corners[0].y << ", " << a.corners[0].z;
            }
        }
    }
}

TEST_P(EveryBuiltinScene, HasCamerasWithUnitAxes) {
    ASSERT_FALSE(scene.cameras.empty());
    for (const Camera& camera : scene.cameras) {
        EXPECT_NEAR(glm::length(camera.forward), 1.0f, 1e-6f) << camera.name;
        EXPECT_NEAR(glm::length(camera.up), 1.0f, 1e-6f) << camera.name;
        EXPECT_NEAR(glm::dot(camera.forward, camera.up), 0.0f, 1e-6f) << camera.name;
    }
}

TEST(BuiltinScene, RefusesAnUnknownNameAndListsTheOthers) {
    try {
        builtin_scene("attic");
        FAIL() << "no error";
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::input);
        EXPECT_STREQ(error.what(), "builtin scene: found no scene named 'attic'; choose one of "
                                   "atrium, fence, wires, sparkle, foliage, plane, sky");
    }
}

std::size_t stored_triangles(const Scene& scene) {
    std::size_t count = 0;
    for (const Mesh& mesh : scene.meshes)
        for (const Primitive& primitive : mesh.primitives) count += primitive.triangles();
    return count;
}

TEST(BuiltinScene, AtriumHasItsSize) {
    const Scene scene = builtin_scene("atrium");
    EXPECT_GE(scene.triangles(), 270'000u);
    EXPECT_LE(scene.triangles(), 290'000u);
    EXPECT_LT(stored_triangles(scene), 100'000u);
    ASSERT_EQ(scene.cameras.size(), 3u);
    ASSERT_EQ(scene.lights.size(), 25u);
    EXPECT_EQ(scene.lights[0].type, LightType::directional);
    EXPECT_TRUE(scene.lights[0].casts_shadow);
    EXPECT_NEAR(glm::length(scene.lights[0].direction), 1.0f, 1e-6f);
    for (std::size_t i = 1; i < scene.lights.size(); ++i) {
        EXPECT_EQ(scene.lights[i].type, LightType::point);
        EXPECT_EQ(scene.lights[i].range, 6.0f);
        EXPECT_EQ(scene.lights[i].window_power, 2.0f);
        EXPECT_EQ(scene.lights[i].softening, 0.1f);
    }
}

// Highlights below a pixel: a bumpy surface, low roughness, light from a point; flat and curved.
TEST(BuiltinScene, SparkleIsBumpyAndSmoothUnderPointLights) {
    const Scene scene = builtin_scene("sparkle");
    std::size_t points = 0;
    for (const Light& light : scene.lights) points += light.type == LightType::point;
    EXPECT_EQ(points, 12u);
    int bumpy = 0, metal = 0;
    for (const Material& material : scene.materials) {
        if (!material.normal_texture.used()) continue;
        ++bumpy;
        metal += material.metallic == 1.0f;
        EXPECT_LE(material.roughness, 0.16f) << material.name;
        EXPECT_FALSE(material.metallic_roughness_texture.used()) << material.name;
    }
    EXPECT_EQ(bumpy, 5);
    EXPECT_EQ(metal, 2);
    std::size_t flat = 0, curved = 0;
    for (const Mesh& mesh : scene.meshes) {
        const Primitive& p = mesh.primitives[0];
        if (!scene.materials[p.material].normal_texture.used()) continue;
        (p.triangles() <= 12 ? flat : curved) += 1;
    }
    EXPECT_EQ(flat, 2u) << "floor and wall";
    EXPECT_EQ(curved, 3u) << "two balls and a vase";
    EXPECT_LE(scene.triangles(), 100'000u);
}

TEST(BuiltinScene, FoliageIsCutOutByAlphaAndHasThinBranches) {
    const Scene scene = builtin_scene("foliage");
    EXPECT_LE(stored_triangles(scene), 40'000u);
    EXPECT_LE(scene.triangles(), 120'000u);
    std::size_t cards = 0;
    for (const Instance& instance : scene.instances)
        for (const Primitive& p : scene.meshes[instance.mesh].primitives) {
            const Material& material = scene.materials[p.material];
            if (!material.masked) continue;
            cards += p.triangles();
            EXPECT_TRUE(material.double_sided) << material.name;
            const TextureImage& image = scene.images[material.base_color_texture.image];
            std::size_t holes = 0;
            for (std::size_t i = 3; i < image.rgba.size(); i += 4) holes += image.rgba[i] < 128;
            const double share = 4.0 * double(holes) / double(image.rgba.size());
            EXPECT_GT(share, 0.3) << image.name;
            EXPECT_LT(share, 0.9) << image.name;
        }
    EXPECT_GT(cards, 40'000u);
    EXPECT_EQ(scene.background, glm::vec3(0.35f, 0.55f, 0.9f));
}

TEST(BuiltinScene, AtriumHasEveryKindOfMaterial) {
    const Scene scene = builtin_scene("atrium");
    int masked = 0, metal = 0, bumpy = 0, double_sided = 0, emissive = 0;
    for (const Material& material : scene.materials) {
        masked += material.masked;
        metal += material.metallic == 1.0f;
        bumpy += material.normal_texture.used();
        double_sided += material.double_sided;
        emissive += material.emissive != glm::vec3(0.0f);
    }
    EXPECT_EQ(masked, 1);
    EXPECT_EQ(metal, 1);
    EXPECT_GE(bumpy, 9);
    EXPECT_EQ(double_sided, 3);
    EXPECT_EQ(emissive, 1);
}

// The mean over a whole number of cells is 0.5 linear only if black and white cover equal areas
// with radiance exactly 0 and 1.
TEST(BuiltinScene, PlaneIsExactlyHalfWhite) {
    const Scene scene = builtin_scene("plane");
    ASSERT_EQ(scene.images.size(), 1u);
    std::map<std::uint8_t, int> count;
    for (std::size_t i = 0; i < scene.images[0].rgba.size(); i += 4)
        ++count[scene.images[0].rgba[i]];
    ASSERT_EQ(count.size(), 2u);
    EXPECT_EQ(count[0], count[255]);
    EXPECT_TRUE(scene.materials[0].unlit);
    const Primitive& ground = scene.meshes[0].primitives[0];
    for (const glm::vec2& uv : ground.uvs[0]) EXPECT_EQ(uv, glm::floor(uv));
    EXPECT_EQ(scene.background, glm::vec3(0.5f));
}

TEST(BuiltinScene, SkyIsEmpty) {
    const Scene scene = builtin_scene("sky");
    EXPECT_EQ(scene.triangles(), 0u);
    EXPECT_TRUE(scene.bounds().empty());
    EXPECT_TRUE(scene.lights.empty());
}

TEST(BuiltinScene, WiresHaveTheirWidths) {
    const Scene scene = builtin_scene("wires");
    const double expected[] = {0.5e-3, 1e-3, 2e-3, 3e-3, 5e-3, 8e-3, 12e-3, 20e-3};
    for (std::size_t wheel = 0; wheel < std::size(expected); ++wheel) {
        Bounds box;
        for (const glm::vec3& p : scene.meshes[wheel].primitives[0].positions) box.add(p);
        // All spokes lie in the plane z = 0, so the box is as deep as a wire is wide.
        EXPECT_NEAR(box.high.z - box.low.z, expected[wheel], 2.0 / 65536) << wheel;
    }
}

TEST(UnitAt, IsOnTheCircleAndExactAtQuarters) {
    EXPECT_EQ(unit_at(0.0), glm::dvec2(1, 0));
    EXPECT_EQ(unit_at(0.25), glm::dvec2(0, 1));
    EXPECT_EQ(unit_at(-0.5), glm::dvec2(-1, 0));
    EXPECT_EQ(unit_at(7.75), glm::dvec2(0, -1));
    for (int i = -50; i <= 50; ++i) {
        const double turns = i * 0.037;
        const double angle = turns * 2.0 * std::numbers::pi;
        EXPECT_NEAR(unit_at(turns).x, std::cos(angle), 4e-15) << turns;
        EXPECT_NEAR(unit_at(turns).y, std::sin(angle), 4e-15) << turns;
    }
}

} // namespace
} // namespace ockham

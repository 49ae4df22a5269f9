// SPDX-License-Identifier: Apache-2.0
// The G-buffer against geometry: which samples are covered, at which depth, with which normal,
// coordinates and material, and what culling and masks leave out.
#include "framework/core/rng.hpp"
#include "passes/surface/gbuffer.hpp"
#include "tests/reference/packing.hpp"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/scene_bench.hpp"
#include "tests/support/surface_scenes.hpp"

#include <glm/gtc/matrix_transform.hpp>

#include <cmath>
#include <numbers>
#include <numeric>

namespace ockham::test {
namespace {

/// All samples of a rendered scene, row-major.
struct Samples {
    std::uint32_t width, height; ///< samples
    std::vector<glm::uvec4> surface;
    std::vector<float> depth;
    std::vector<glm::uvec4> extra; ///< empty: the scene does not need it
    shader::FrameData frame;

    std::size_t place(std::uint32_t x, std::uint32_t y) const { return std::size_t{y} * width + x; }
    bool hit(std::uint32_t x, std::uint32_t y) const { return depth[place(x, y)] > 0.0f; }
    glm::vec3 normal(std::uint32_t x, std::uint32_t y) const {
        return reference::unpack_normal(surface[place(x, y)].x);
    }
    std::size_t hits() const {
        std::size_t count = 0;
        for (const float d : depth) count += d > 0.0f;
        return count;
    }
};

class GbufferTest : public GpuTest {
protected:
    static Samples rasterise(const Scene& scene, const Camera& camera, std::uint32_t width,
        std::uint32_t height, std::uint32_t m) {
        std::vector<std::uint32_t> order(m * m);
        std::iota(order.begin(), order.end(), 0u);
        SceneBench bench(device(), scene, camera, width, height, m, order);
        const Gbuffer gbuffer = add_gbuffer(
            bench.graph, bench.inputs, {width, height, m}, device().limits().attachment_extent);
        bench.graph.export_resource(gbuffer.depth, "test");
        const ImageHandle surface = bench.keep(gbuffer.surface);
        const ImageHandle extra = gbuffer.extra ? bench.keep(gbuffer.extra) : ImageHandle{};
        bench.execute();
        Samples samples{
            m * width, m * height, bench.texels<glm::uvec4>(surface), {}, {}, bench.frame};
        const Image depth = bench.read(gbuffer.depth);
        samples.depth.assign(depth.plane(0).begin(), depth.plane(0).end());
        if (extra) samples.extra = bench.texels<glm::uvec4>(extra);
        return samples;
    }
    /// Samples between two places of a corner that this driver can tell apart.
    static double corner_grid() {
        VkPhysicalDeviceProperties properties;
        vkGetPhysicalDeviceProperties(device().physical(), &properties);
        return std::exp2(-static_cast<double>(properties.limits.subPixelPrecisionBits));
    }
    static Scene scene_of(Primitive primitive, Material material = {}) {
        Scene scene;
        scene.materials = {material};
        add(scene, std::move(primitive));
        return scene;
    }
};

/// Twice the signed area: > 0 left of a -> b.
double edge(glm::dvec2 a, glm::dvec2 b, glm::dvec2 p) {
    return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
}

TEST_F(GbufferTest, TrianglesCoverTheSamplesInsideThem) {
    Pcg32 rng(11);
    for (const auto& [width, height] : {std::pair{1u, 1u}, {7u, 5u}, {64u, 64u}}) {
        for (const std::uint32_t m : {1u, 2u, 3u, 4u}) {
            SCOPED_TRACE(testing::Message() << width << "x" << height << ", m = " << m);
            glm::vec3 corner[3];
            double area = 0;
            while (area < 0.1 * width * height) { // counter-clockwise, and not a sliver
                for (glm::vec3& c : corner) {
                    c = {rng.uniform(-0.5f, 1.5f) * static_cast<float>(width),
                        rng.uniform(-0.5f, 1.5f) * static_cast<float>(height), 0};
                }
                area = edge(glm::vec2(corner[0]), glm::vec2(corner[1]), glm::vec2(corner[2]));
            }
            const Samples samples = rasterise(scene_of(triangle(corner[0], corner[1], corner[2])),
                pixel_camera(width, height), width, height, m);
            std::size_t doubtful = 0;
            for (std::uint32_t y = 0; y < samples.height; ++y) {
                for (std::uint32_t x = 0; x < samples.width; ++x) {
                    const glm::dvec2 p((x + 0.5) / m, height - (y + 0.5) / m);
                    bool inside = true, near_edge = false;
                    for (int e = 0; e < 3; ++e) {
                        const glm::dvec2 a(corner[e]), b(corner[(e + 1) % 3]);
                        const double distance = edge(a, b, p) / glm::length(b - a);
                        inside &= distance > 0;
                        near_edge |=
                            std::abs(distance) < 1.5 * corner_grid() / m; // rasterisers snap
                    }
                    doubtful += near_edge;
                    if (!near_edge) {
                        EXPECT_EQ(samples.hit(x, y), inside) << x << "," << y;
                    }
                }
            }
            EXPECT_LT(doubtful, 1 + 13 * corner_grid() * static_cast<double>(samples.depth.size()));
        }
    }
}

/// Area of a unit pixel below a line at signed distance `d` from its centre, normal (a, b).
double half_plane_coverage(double d, double normal_x, double normal_y) {
    const double a = std::max(std::abs(normal_x), std::abs(normal_y));
    const double b = std::min(std::abs(normal_x), std::abs(normal_y));
    if (std::abs(d) >= 0.5 * (a + b)) return d > 0 ? 1 : 0;
    if (std::abs(d) <= 0.5 * (a - b)) return 0.5 + d / a;
    const double rest = std::pow(0.5 * (a + b) - std::abs(d), 2) / (2 * a * b);
    return d > 0 ? 1 - rest : rest;
}

TEST_F(GbufferTest, HalfPlanesAreCoveredToHalfASampleRow) {
    constexpr std::uint32_t kSize = 15;
    for (int degrees = 0; degrees <= 90; degrees += 15) {
        const double angle = degrees * std::numbers::pi / 180;
        const glm::dvec2 normal(std::cos(angle), std::sin(angle)), along(-normal.y, normal.x);
        const glm::dvec2 origin(7.5 + 0.31, 7.5 - 0.17);
        // The half-plane on the inner side of the line through `origin`, as one large rectangle.
        const glm::dvec2 corner = origin - 40.0 * along - 60.0 * normal;
        const Scene scene = scene_of(rectangle(
            glm::vec3(corner, 0), glm::vec3(60.0 * normal, 0), glm::vec3(80.0 * along, 0)));
        for (const std::uint32_t m : {1u, 2u, 3u, 4u}) {
            const Samples samples = rasterise(scene, pixel_camera(kSize, kSize), kSize, kSize, m);
            for (std::uint32_t y = 0; y < kSize; ++y) {
                for (std::uint32_t x = 0; x < kSize; ++x) {
                    int covered = 0;
                    for (std::uint32_t i = 0; i < m * m; ++i)
                        covered += samples.hit(x * m + i % m, y * m + i / m);
                    const glm::dvec2 center(x + 0.5, kSize - y - 0.5);
                    const double d = glm::dot(origin - center, normal);
                    EXPECT_NEAR(static_cast<double>(covered) / (m * m),
                        half_plane_coverage(d, normal.x, normal.y), (0.5 + 2 * corner_grid()) / m)
                        << degrees << " degrees, m = " << m << ", pixel " << x << "," << y;
                }
            }
        }
    }
}

TEST_F(GbufferTest, DepthIsNearOverViewDepth) {
    // A steep triangle with its corners on whole samples, where no driver moves them before it
    // interpolates.
    constexpr std::uint32_t kWidth = 32, kHeight = 24, kM = 2;
    const glm::dvec2 place[] = {{2, 2}, {62, 4}, {30, 46}}; // samples, y up
    const double depth[] = {3, 5, 150};
    const Camera camera = look_at({0, 1, 10}, {0, 0, -10}, 70);
    const glm::dvec3 forward(camera.forward);
    const glm::dvec3 right = glm::normalize(glm::cross(forward, glm::dvec3(camera.up)));
    const glm::dvec3 up = glm::cross(right, forward);
    const double sample = std::tan(glm::radians(35.0)) * 2 / (kM * kHeight);
    glm::vec3 corner[3];
    for (int i = 0; i < 3; ++i) {
        const glm::dvec2 from_centre = sample * (place[i] - glm::dvec2(32, 24));
        corner[i] = glm::dvec3(camera.position) +
                    depth[i] * (forward + from_centre.x * right + from_centre.y * up);
    }
    const Samples samples =
        rasterise(scene_of(triangle(corner[0], corner[1], corner[2])), camera, kWidth, kHeight, kM);
    const double area = edge(place[0], place[1], place[2]);
    for (std::uint32_t y = 0; y < samples.height; ++y) {
        for (std::uint32_t x = 0; x < samples.width; ++x) {
            if (!samples.hit(x, y)) continue;
            const glm::dvec2 p(x + 0.5, samples.height - y - 0.5);
            double inverse = 0; // linear over the picture
            for (int i = 0; i < 3; ++i)
                inverse += edge(place[(i + 1) % 3], place[(i + 2) % 3], p) / area / depth[i];
            const double stored = samples.depth[samples.place(x, y)];
            EXPECT_NEAR(samples.frame.near_distance / stored * inverse, 1, 2e-5) << x << "," << y;
        }
    }
    EXPECT_NEAR(static_cast<double>(samples.hits()), 0.5 * area, 0.05 * area);
}

TEST_F(GbufferTest, NormalsSurviveThePackingInEveryDirection) {
    Pcg32 rng(5);
    for (int i = 0; i < 24; ++i) {
        const glm::vec3 wanted = glm::normalize(
            glm::vec3(rng.uniform(-1, 1), rng.uniform(-1, 1), i < 6 ? -0.01f : rng.uniform(-1, 1)));
        const glm::vec3 side = glm::normalize(glm::cross(wanted, glm::vec3(0.3f, 0.5f, 0.81f)));
        const glm::vec3 top = glm::cross(wanted, side);
        const Scene scene = scene_of(rectangle(-side - top, 2.0f * side, 2.0f * top));
        const Samples samples = rasterise(scene, look_at(3.0f * wanted, {0, 0, 0}, 20), 3, 3, 1);
        ASSERT_TRUE(samples.hit(1, 1));
        EXPECT_LT(glm::length(samples.normal(1, 1) - wanted), 1e-4f);
    }
}

TEST_F(GbufferTest, CoordinatesKeep20BitsAndDerivativesAnEighthOfAnOctave) {
    for (const float scale : {0.03f, 1.0f, 7.3f, 900.0f}) {
        for (const bool flipped : {false, true}) {
            Material material;
            Scene scene;
            material.base_color_texture.image =
                add_image(scene, 4, 4, [](int, int) { return glm::u8vec4(255); });
            if (flipped) { // u' = 0.2 - v, v' = u
                material.base_color_texture.transform_u = {0, -1, 0.2f};
                material.base_color_texture.transform_v = {1, 0, 0};
            }
            scene.materials = {material};
            const glm::vec2 uv_scale(scale, 0.6f * scale);
            add(scene, rectangle({0, 0, 0}, {16, 0, 0}, {0, 8, 0}, 0, uv_scale));
            const Samples samples = rasterise(scene, pixel_camera(16, 8), 16, 8, 2);
            for (std::uint32_t y = 0; y < samples.height; ++y) {
                for (std::uint32_t x = 0; x < samples.width; ++x) {
                    ASSERT_TRUE(samples.hit(x, y));
                    const glm::uvec4 words = samples.surface[samples.place(x, y)];
                    const double u = (x + 0.5) / 32 * uv_scale.x, v = (y + 0.5) / 16 * uv_scale.y;
                    const double wanted[2] = {flipped ? 0.2f - v : u, flipped ? u : v};
                    const double slope_x = uv_scale.x / 32, slope_y = uv_scale.y / 16;
                    const double gradient[4] = {flipped ? 0 : slope_x, flipped ? slope_x : 0,
                        flipped ? -slope_y : 0, flipped ? 0 : slope_y};
                    for (int i = 0; i < 2; ++i) {
                        const double found = reference::unpack_uv(i == 0 ? words.z : words.w);
                        double error = found - wanted[i];
                        error -= std::round(error);
                        // Half a step of 2^-20, and the interpolation's fp32.
                        EXPECT_LE(std::abs(error), 0x1p-21 + 2e-6 * std::max(1.0f, scale));
                    }
                    for (int i = 0; i < 4; ++i) {
                        const double found = reference::unpack_derivative(words.y, i);
                        if (gradient[i] == 0) {
                            EXPECT_LT(std::abs(found), 1e-5 * scale);
                        } else {
                            EXPECT_NEAR(found / gradient[i], 1.0, 0.0906) << "2^(1/8) - 1";
                        }
                    }
                }
            }
        }
    }
}

TEST_F(GbufferTest, MaterialsAreToldApartBeyondTwelveBits) {
    Scene scene;
    scene.materials.resize(70000);
    add(scene, rectangle({0, 0, 0}, {2, 0, 0}, {0, 4, 0}, 4095));
    add(scene, rectangle({2, 0, 0}, {2, 0, 0}, {0, 4, 0}, 69999));
    const Samples samples = rasterise(scene, pixel_camera(4, 4), 4, 4, 2);
    for (std::uint32_t y = 0; y < 8; ++y) {
        for (std::uint32_t x = 0; x < 8; ++x) {
            EXPECT_EQ(reference::unpack_material(samples.surface[samples.place(x, y)]),
                x < 4 ? 4095u : 69999u);
        }
    }
}

TEST_F(GbufferTest, MaskedTexelsAreHolesPerSample) {
    Scene scene;
    Material material;
    material.base_color_texture.image = add_image(scene, 16, 16,
        [](int x, int y) { return glm::u8vec4(255, 255, 255, (x / 4 + y / 4) % 2 ? 255 : 0); });
    material.masked = true;
    scene.materials = {material};
    add(scene, rectangle({0, 0, 0}, {4, 0, 0}, {0, 4, 0}));
    // A masked material without an image, by its factor and vertex colours.
    Material clear;
    clear.masked = true;
    clear.base_color.a = 0.6f;
    scene.materials.push_back(clear);
    Primitive fading = rectangle({4, 0, 0}, {4, 0, 0}, {0, 4, 0}, 1);
    fading.colors = {{1, 1, 1, 0}, {1, 1, 1, 1}, {1, 1, 1, 1}, {1, 1, 1, 0}};
    add(scene, std::move(fading));
    const Samples samples = rasterise(scene, pixel_camera(8, 4), 8, 4, 4);
    for (std::uint32_t y = 0; y < 16; ++y) {
        for (std::uint32_t x = 0; x < 16; ++x)
            EXPECT_EQ(samples.hit(x, y), (x / 4 + y / 4) % 2 == 1) << x << "," << y;
        for (std::uint32_t x = 16; x < 32; ++x) // 0.6 a >= 0.5: a from 5/6
            EXPECT_EQ(samples.hit(x, y), (x - 16 + 0.5) / 16 >= 5.0 / 6) << x << "," << y;
    }
}

TEST_F(GbufferTest, BackFacesAreCulledUnlessDoubleSided) {
    const Primitive away = rectangle({4, 0, 0}, {-4, 0, 0}, {0, 4, 0}); // front along -z
    EXPECT_EQ(rasterise(scene_of(away), pixel_camera(4, 4), 4, 4, 1).hits(), 0u);
    Material both;
    both.double_sided = true;
    const Samples samples = rasterise(scene_of(away, both), pixel_camera(4, 4), 4, 4, 1);
    EXPECT_EQ(samples.hits(), 16u);
    EXPECT_LT(glm::length(samples.normal(2, 2) - glm::vec3(0, 0, 1)), 1e-4f)
        << "the normal turns towards the camera";
}

TEST_F(GbufferTest, MirroredInstancesKeepTheirFronts) {
    const glm::mat4 mirror =
        glm::scale(glm::translate(glm::mat4(1.0f), {4, 0, 0}), glm::vec3(-1, 1, 1));
    for (const bool front : {true, false}) {
        Scene scene;
        scene.materials = {Material{}};
        const glm::vec3 across = front ? glm::vec3(4, 0, 1) : glm::vec3(-4, 0, -1);
        const glm::vec3 corner = front ? glm::vec3(0) : glm::vec3(4, 0, 1);
        const Primitive primitive = rectangle(corner, across, {0, 4, 0});
        add(scene, primitive, mirror);
        const Samples samples = rasterise(scene, pixel_camera(4, 4), 4, 4, 1);
        ASSERT_EQ(samples.hits(), front ? 16u : 0u);
        if (!front) continue;
        const glm::vec3 plain = primitive.normals[0];
        EXPECT_LT(glm::length(samples.normal(1, 1) - glm::vec3(-plain.x, plain.y, plain.z)), 1e-4f);
    }
}

TEST_F(GbufferTest, NormalsFollowNonUniformScale) {
    Scene scene;
    scene.materials = {Material{}};
    const glm::mat4 squash = glm::scale(glm::mat4(1.0f), glm::vec3(1, 1, 3));
    add(scene, rectangle({0, 0, 0}, {4, 0, 1}, {0, 4, 0}), squash);
    const Samples samples = rasterise(scene, pixel_camera(4, 4), 4, 4, 1);
    EXPECT_LT(glm::length(samples.normal(1, 1) - glm::normalize(glm::vec3(-3, 0, 4))), 1e-4f);
}

TEST_F(GbufferTest, NormalMapTurnsTheNormalByItsTangents) {
    // A texel of constant (0.6, 0, 0.8): towards +tangent, then green: towards the image's top.
    const glm::vec3 bumps[] = {{0.6f, 0, 0.8f}, {0, 0.6f, 0.8f}};
    for (const glm::vec3 bump : bumps) {
        Scene scene;
        Material material;
        const glm::vec3 bytes = 127.5f * (bump + 1.0f) + 0.5f;
        material.normal_texture.image =
            add_image(scene, 4, 4, [&](int, int) { return glm::u8vec4(glm::u8vec3(bytes), 255); });
        scene.materials = {material};
        add(scene, rectangle({0, 0, 0}, {4, 0, 0}, {0, 4, 0}));
        const Samples samples = rasterise(scene, pixel_camera(4, 4), 4, 4, 1);
        EXPECT_LT(glm::length(samples.normal(1, 1) - bump), 0.01f) << "8-bit texels";

        // A mirrored instance mirrors the bump across x and leaves its height along y.
        scene.instances.front().world = glm::translate(glm::mat4(1.0f), glm::vec3(4, 0, 0)) *
                                        glm::scale(glm::mat4(1.0f), glm::vec3(-1, 1, 1));
        const Samples mirrored = rasterise(scene, pixel_camera(4, 4), 4, 4, 1);
        EXPECT_LT(glm::length(mirrored.normal(1, 1) - bump * glm::vec3(-1, 1, 1)), 0.01f);
    }
}

TEST_F(GbufferTest, SecondTargetExistsOnlyForColoursOrSecondCoordinates) {
    const Primitive plain = rectangle({0, 0, 0}, {4, 0, 0}, {0, 4, 0});
    EXPECT_TRUE(rasterise(scene_of(plain), pixel_camera(4, 4), 4, 4, 1).extra.empty());
    Primitive colored = plain;
    colored.colors.assign(4, glm::vec4(0.25f, 0.5f, 1, 1));
    const Samples samples = rasterise(scene_of(colored), pixel_camera(4, 4), 4, 4, 1);
    ASSERT_FALSE(samples.extra.empty());
    const std::uint32_t word = samples.extra[5].x;
    const auto channel = [](std::uint32_t code, float most) {
        return std::pow(static_cast<float>(code) / most, 2.0f);
    };
    EXPECT_NEAR(channel(word & 2047u, 2047), 0.25f, 1e-3f);
    EXPECT_NEAR(channel((word >> 11) & 2047u, 2047), 0.5f, 1e-3f);
    EXPECT_NEAR(channel(word >> 22, 1023), 1.0f, 1e-3f);

    Scene two;
    Material material;
    material.base_color_texture.image =
        add_image(two, 4, 4, [](int, int) { return glm::u8vec4(255); });
    material.emissive_texture = material.base_color_texture;
    material.emissive_texture.uv_set = 1;
    two.materials = {material};
    Primitive mapped = plain;
    mapped.uvs[1].assign(4, glm::vec2(0.75f, 0.5f));
    add(two, std::move(mapped));
    const Samples second = rasterise(two, pixel_camera(4, 4), 4, 4, 1);
    ASSERT_FALSE(second.extra.empty());
    EXPECT_NEAR(reference::unpack_uv(second.extra[5].z), 0.75f, 1e-5f);
    EXPECT_NEAR(reference::unpack_uv(second.extra[5].w), 0.5f, 1e-5f);
}

TEST_F(GbufferTest, EmptySceneIsAllBackground) {
    EXPECT_EQ(rasterise({}, look_at({0, 0, 5}, {0, 0, 0}, 60), 7, 5, 3).hits(), 0u);
}

TEST_F(GbufferTest, TooManySamplesAreRefusedNamingBothSizes) {
    const Scene scene = scene_of(rectangle({0, 0, 0}, {4, 0, 0}, {0, 4, 0}));
    SceneBench bench(device(), scene, pixel_camera(4, 4), 4, 4, 1, {0});
    const std::string text = error_of([&] {
        add_gbuffer(bench.graph, bench.inputs, {4000, 300, 4}, 15999);
    });
    for (const char* part : {"4000 x 300", "m = 4", "16000 x 1200", "15999"})
        EXPECT_NE(text.find(part), std::string::npos) << text;
}

} // namespace
} // namespace ockham::test

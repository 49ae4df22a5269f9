// SPDX-License-Identifier: Apache-2.0
// Shading of one sample a pixel: radiance against a C++ twin of the BRDF and the lights, textures
// against their texels, footprints against material edges.
#include "framework/core/image.hpp"
#include "framework/core/rng.hpp"
#include "passes/pipelines/adaptive_aa.hpp"
#include "tests/reference/shading.hpp"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/surface_scenes.hpp"

#include <cmath>
#include <numbers>

namespace ockham::test {
namespace {

class FirstSampleTest : public GpuTest {
protected:
    /// m = 1: the first sample is the picture.
    static Image render(
        Scene scene, const Camera& camera, std::uint32_t width, std::uint32_t height) {
        return render_s(std::move(scene), camera, width, height, 1);
    }
    /// S of m x m windows, shaded for the whole pixel.
    static Image render_s(Scene scene, const Camera& camera, std::uint32_t width,
        std::uint32_t height, std::uint32_t m, Resolve resolve = Resolve::prefix) {
        const LitScene lit(device(), std::move(scene));
        AdaptiveAaParams params;
        params.width = width;
        params.height = height;
        params.m = m;
        params.resolve = resolve;
        params.captures = {"first_sample"};
        AdaptiveAa aa(device(), lit, camera, params);
        aa.execute();
        return aa.executor().read(aa.outputs().first_sample);
    }
};

/// A board of 8 x 8 unit squares in the plane z = 0 around the origin, each of its own material.
Scene board(std::uint64_t seed) {
    Pcg32 rng(seed);
    Scene scene;
    scene.ambient = {0.1f, 0.2f, 0.05f};
    for (int i = 0; i < 64; ++i) {
        Material material;
        material.base_color = {rng.uniform(), rng.uniform(), rng.uniform(), 1.0f};
        material.metallic = rng.below(3) ? rng.uniform() : 0.0f;
        material.roughness = rng.uniform(0.3f, 1.0f);
        material.ior = rng.uniform(1.0f, 2.0f);
        material.emissive =
            rng.below(4) ? glm::vec3(0.0f) : glm::vec3(rng.uniform(), rng.uniform(), 2.0f);
        material.unlit = rng.below(8) == 0;
        scene.materials.push_back(material);
        add(scene, rectangle({static_cast<float>(i % 8 - 4), static_cast<float>(i / 8 - 4), 0},
                       {1, 0, 0}, {0, 1, 0}, i));
    }
    return scene;
}

Light directional() {
    Light light;
    light.type = LightType::directional;
    light.direction = glm::normalize(glm::vec3(0.3f, -0.5f, -1.0f));
    light.intensity = {3, 2, 1};
    return light;
}
Light gltf_point() {
    Light light;
    light.position = {-1, 2, 2};
    light.intensity = {4, 9, 6};
    light.range = 4.5f;
    return light;
}
Light rig_point() {
    Light light;
    light.position = {2, -1, 1.5f};
    light.intensity = {2, 1, 5};
    light.range = 5.0f;
    light.window_power = 2.0f;
    light.softening = 0.1f;
    return light;
}
Light spot() {
    Light light;
    light.type = LightType::spot;
    light.position = {0, 0, 3};
    light.direction = glm::normalize(glm::vec3(0.2f, 0.1f, -1));
    light.intensity = {9, 9, 2};
    light.inner_cone = 0.3f;
    light.outer_cone = 0.7f;
    return light;
}

TEST_F(FirstSampleTest, RadianceAgreesWithTheTwinForEveryKindOfLight) {
    // Straight down: depth is the same everywhere, wherever a driver's rasteriser moves corners.
    const Camera camera = look_at({0.5f, -0.4f, 4.5f}, {0.5f, -0.4f, 0}, 80);
    constexpr int kWidth = 64, kHeight = 48;
    const std::vector<std::vector<Light>> rigs = {{}, {directional()}, {gltf_point()},
        {rig_point()}, {spot()}, {spot(), rig_point(), directional(), gltf_point(), directional()}};
    for (std::size_t r = 0; r < rigs.size(); ++r) {
        Scene scene = board(r);
        scene.lights = rigs[r];
        const Image picture = render(scene, camera, kWidth, kHeight);
        const double half = std::tan(0.5 * 80 * std::numbers::pi / 180);
        const glm::dvec3 right =
            glm::normalize(glm::cross(glm::dvec3(camera.forward), glm::dvec3(camera.up)));
        std::size_t compared = 0;
        for (int y = 0; y < kHeight; ++y) {
            for (int x = 0; x < kWidth; ++x) {
                const glm::dvec3 ray =
                    glm::dvec3(camera.forward) +
                    half * kWidth / kHeight * (2 * (x + 0.5) / kWidth - 1) * right +
                    half * (1 - 2 * (y + 0.5) / kHeight) * glm::dvec3(camera.up);
                const glm::dvec3 eye(camera.position);
                const glm::dvec3 point = eye - eye.z / ray.z * ray;
                const glm::dvec2 cell = glm::floor(glm::dvec2(point));
                const glm::dvec2 inside = glm::abs(glm::dvec2(point) - cell - 0.5);
                if (std::max(inside.x, inside.y) > 0.49 ||
                    std::max(std::abs(cell.x + 0.5), std::abs(cell.y + 0.5)) > 4)
                    continue;
                const Material& material =
                    scene.materials[static_cast<std::size_t>((cell.y + 4) * 8 + cell.x + 4)];
                const glm::dvec3 expected = reference::radiance(scene, material,
                    glm::dvec3(material.base_color), {0, 0, 1}, point, glm::normalize(eye - point));
                for (int c = 0; c < 3; ++c) {
                    ASSERT_NEAR(picture.at(x, y, c), expected[c], 1e-4 * expected[c] + 1e-6)
                        << "rig " << r << ", pixel " << x << "," << y << ", channel " << c
                        << ", roughness " << material.roughness;
                }
                EXPECT_EQ(picture.at(x, y, 3), 1.0f);
                ++compared;
            }
        }
        EXPECT_GT(compared, 1000u);
    }
}

TEST_F(FirstSampleTest, UnlitColourIsTheRadiance) {
    Scene scene;
    scene.background = {7, 8, 9};
    scene.ambient = glm::vec3(5.0f);
    scene.lights = {directional(), gltf_point()};
    scene.materials = {unlit_material({0.125f, 0.3f, 1.0f})};
    add(scene, rectangle({0, 0, 0}, {4, 0, 0}, {0, 4, 0}));
    const Image picture = render(scene, pixel_camera(8, 4), 8, 4);
    for (int x = 0; x < 8; ++x) {
        const glm::vec4 expected = x < 4 ? glm::vec4(0.125f, 0.3f, 1, 1) : glm::vec4(7, 8, 9, 0);
        for (int c = 0; c < 4; ++c) EXPECT_EQ(picture.at(x, 2, c), expected[c]);
    }
}

TEST_F(FirstSampleTest, LambertUnderASunHasTheClosedForm) {
    Scene scene;
    Material material;
    material.base_color = {0.8f, 0.4f, 0.2f, 1.0f};
    material.metallic = 0.0f;
    material.ior = 1.0f; // no reflectance at normal incidence; the light comes from the camera
    scene.materials = {material};
    Light sun = directional();
    sun.direction = {0, 0, -1};
    scene.lights = {sun};
    add(scene, rectangle({0, 0, 0}, {4, 0, 0}, {0, 4, 0}));
    const Image picture = render(scene, pixel_camera(4, 4), 4, 4);
    for (int c = 0; c < 3; ++c) {
        const double expected = material.base_color[c] * sun.intensity[c] / std::numbers::pi;
        EXPECT_NEAR(picture.at(1, 1, c), expected, 1e-5 * expected);
    }
}

TEST_F(FirstSampleTest, ReflectionNeverGivesBackMoreThanItGets) {
    // White everywhere is the worst case. Midpoint rule over the hemisphere of lights.
    Pcg32 rng(4);
    for (int i = 0; i < 40; ++i) {
        Material material;
        material.metallic = i % 2 ? 1.0f : rng.uniform();
        material.roughness = rng.uniform(0.25f, 1.0f);
        material.ior = rng.uniform(1.0f, 2.0f);
        const double cosine = rng.uniform(0.02f, 1.0f);
        const glm::dvec3 v(std::sqrt(1 - cosine * cosine), 0, cosine);
        constexpr int kPolar = 300, kAround = 300;
        glm::dvec3 sum(0.0);
        for (int p = 0; p < kPolar; ++p) {
            const double z = (p + 0.5) / kPolar, s = std::sqrt(1 - z * z);
            for (int a = 0; a < kAround; ++a) {
                const double phi = 2 * std::numbers::pi * (a + 0.5) / kAround;
                sum += reference::reflect_light(material, glm::dvec3(1.0), {0, 0, 1}, v,
                    {s * std::cos(phi), s * std::sin(phi), z});
            }
        }
        sum *= 2 * std::numbers::pi / (kPolar * kAround);
        EXPECT_LE(sum.x, 1.005) << "roughness " << material.roughness << ", metallic "
                                << material.metallic << ", ior " << material.ior << ", cosine "
                                << cosine;
        EXPECT_GT(sum.x, 0.3);
    }
}

TEST_F(FirstSampleTest, VertexColoursMultiplyTheBaseColour) {
    Scene scene;
    scene.materials = {unlit_material({0.5f, 1.0f, 0.8f})};
    Primitive p = rectangle({0, 0, 0}, {4, 0, 0}, {0, 4, 0});
    p.colors.assign(4, {0.25f, 0.5f, 1.0f, 1.0f});
    add(scene, std::move(p));
    const Image picture = render(scene, pixel_camera(4, 4), 4, 4);
    EXPECT_NEAR(picture.at(1, 1, 0), 0.125f, 1e-3f);
    EXPECT_NEAR(picture.at(1, 1, 1), 0.5f, 1e-3f);
    EXPECT_NEAR(picture.at(1, 1, 2), 0.8f, 1e-3f);
}

TEST_F(FirstSampleTest, TexelsDecodeToTheirOwnCode) {
    // All 256 codes, one texel a pixel: what comes out rounds to the code that went in. (Some
    // drivers decode sRGB by a polynomial, up to a third of a code off.)
    Scene scene;
    Material material = unlit_material();
    material.base_color_texture.image = add_image(scene, 16, 16, [](int x, int y) {
        const auto code = static_cast<unsigned char>(16 * y + x);
        return glm::u8vec4(code, 255 - code, code ^ 0x55, 255);
    });
    scene.materials = {material};
    add(scene, rectangle({0, 0, 0}, {16, 0, 0}, {0, 16, 0}));
    const Image picture = render(scene, pixel_camera(16, 16), 16, 16);
    for (int y = 0; y < 16; ++y) {
        for (int x = 0; x < 16; ++x) {
            const int code = 16 * y + x, codes[3] = {code, 255 - code, code ^ 0x55};
            for (int c = 0; c < 3; ++c) {
                EXPECT_NEAR(255 * srgb_encode(picture.at(x, y, c)), codes[c], 0.5);
            }
        }
    }
}

TEST_F(FirstSampleTest, ConstantTextureHasItsColourAtEveryFootprint) {
    Scene scene;
    Material material = unlit_material();
    material.base_color_texture.image =
        add_image(scene, 13, 7, [](int, int) { return glm::u8vec4(120, 40, 200, 255); });
    add_image(scene, 32, 64, [](int, int) { return glm::u8vec4(0, 0, 0, 255); });
    Material other = unlit_material();
    other.base_color_texture.image = 1; // makes the array's layers larger than the first image
    scene.materials = {material, other};
    add(scene, rectangle({-2000, 0, 0}, {4000, 0, 0}, {0, 0, -4000}, 0, {1500, 1500}));
    add(scene, rectangle({-1, 5, -10}, {2, 0, 0}, {0, 1, 0}, 1));
    const Image picture = render(scene, look_at({0.3f, 2, 0}, {0.3f, 1.5f, -10}, 50), 48, 36);
    for (int y = 24; y < 36; ++y) {
        for (int x = 0; x < 48; ++x) {
            EXPECT_NEAR(255 * srgb_encode(picture.at(x, y, 0)), 120, 0.5);
            EXPECT_NEAR(255 * srgb_encode(picture.at(x, y, 2)), 200, 0.5);
        }
    }
}

TEST_F(FirstSampleTest, CheckerIsItsMeanWhereItIsSmallerThanAPixel) {
    Scene scene;
    Material material = unlit_material();
    material.base_color_texture.image = add_image(scene, 2, 2,
        [](int x, int y) { return (x + y) % 2 ? glm::u8vec4(255) : glm::u8vec4(0, 0, 0, 255); });
    scene.materials = {material};
    add(scene, rectangle({0, 0, 0}, {16, 0, 0}, {0, 16, 0}, 0, {111.3f, 75.7f}));
    const Image picture = render(scene, pixel_camera(16, 16), 16, 16);
    for (const float v : picture.plane("G")) EXPECT_NEAR(v, 0.5f, 0.005f);
}

TEST_F(FirstSampleTest, ConstantDataTexturesEqualTheirFactors) {
    Scene factors;
    Material material;
    material.base_color = {0.7f, 0.6f, 0.5f, 1};
    material.metallic = 102.0f / 255;
    material.roughness = 153.0f / 255;
    factors.materials = {material};
    factors.ambient = glm::vec3(0.5f * (1 - 0.75f * (1 - 51.0f / 255)));
    factors.lights = {directional()};
    add(factors, rectangle({0, 0, 0}, {8, 0, 0}, {0, 8, 0}));
    Scene textures = factors;
    textures.ambient = glm::vec3(0.5f);
    Material& textured = textures.materials[0];
    textured.metallic = textured.roughness = 1.0f;
    textured.metallic_roughness_texture.image =
        add_image(textures, 4, 4, [](int, int) { return glm::u8vec4(51, 153, 102, 255); });
    textured.occlusion_texture = textured.metallic_roughness_texture;
    textured.occlusion_strength = 0.75f;
    const Image a = render(factors, pixel_camera(8, 8), 8, 8);
    const Image b = render(textures, pixel_camera(8, 8), 8, 8);
    for (int y = 0; y < 8; ++y) {
        for (int x = 0; x < 8; ++x) {
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(a.at(x, y, c), b.at(x, y, c), 1e-5 * a.at(x, y, c));
        }
    }
}

TEST_F(FirstSampleTest, EmissiveImagesMayUseTheSecondCoordinates) {
    Scene scene;
    Material material;
    material.base_color = {0, 0, 0, 1};
    material.ior = 1.0f;
    material.metallic = 0.0f;
    material.emissive = {2, 2, 2};
    material.base_color_texture.image =
        add_image(scene, 4, 4, [](int, int) { return glm::u8vec4(255); });
    material.emissive_texture.image = add_image(scene, 8, 8, [](int x, int) {
        return x < 4 ? glm::u8vec4(255, 0, 0, 255) : glm::u8vec4(0, 255, 0, 255);
    });
    material.emissive_texture.uv_set = 1;
    scene.materials = {material};
    Primitive p = rectangle({0, 0, 0}, {8, 0, 0}, {0, 8, 0});
    p.uvs[1] = {{1, 1}, {0, 1}, {0, 0}, {1, 0}}; // mirrored
    add(scene, std::move(p));
    const Image picture = render(scene, pixel_camera(8, 8), 8, 8);
    EXPECT_NEAR(picture.at(1, 4, 0), 0.0f, 1e-4f);
    EXPECT_NEAR(picture.at(1, 4, 1), 2.0f, 1e-4f);
    EXPECT_NEAR(picture.at(6, 4, 0), 2.0f, 1e-4f);
}

TEST_F(FirstSampleTest, WrapModesFoldTheCoordinates) {
    // Four texels in a row over u = -1 ... 2.
    for (const Wrap wrap : {Wrap::repeat, Wrap::clamp, Wrap::mirror}) {
        Scene scene;
        Material material = unlit_material();
        const unsigned char codes[4] = {10, 90, 170, 250};
        material.base_color_texture.image = add_image(scene, 4, 1,
            [&](int x, int) { return glm::u8vec4(codes[x], codes[x], codes[x], 255); });
        material.base_color_texture.wrap_u = wrap;
        material.base_color_texture.transform_u = {1, 0, -1};
        scene.materials = {material};
        add(scene, rectangle({0, 0, 0}, {12, 0, 0}, {0, 1, 0}, 0, {3, 1}));
        const Image picture = render(scene, pixel_camera(12, 1), 12, 1);
        for (int x = 0; x < 12; ++x) {
            const int texel = wrap == Wrap::repeat  ? x % 4
                              : wrap == Wrap::clamp ? std::clamp(x - 4, 0, 3)
                              : x / 4 == 1          ? x % 4
                                                    : 3 - x % 4;
            EXPECT_NEAR(255 * srgb_encode(picture.at(x, 0, 0)), codes[texel], 0.5)
                << "wrap " << static_cast<int>(wrap) << ", pixel " << x;
        }
    }
}

TEST_F(FirstSampleTest, MirrorsShowTheSameTexelOnBothSidesOfTheirSeam) {
    // Four texels magnified eight times, mirrored about x = 32: no trace of the far border there.
    Scene scene;
    Material material = unlit_material();
    material.base_color_texture.image = add_image(scene, 4, 1,
        [](int x, int) { return x == 0 ? glm::u8vec4(0, 0, 0, 255) : glm::u8vec4(255); });
    material.base_color_texture.wrap_u = Wrap::mirror;
    material.base_color_texture.transform_u = {1, 0, -1};
    scene.materials = {material};
    add(scene, rectangle({0, 0, 0}, {64, 0, 0}, {0, 1, 0}, 0, {2, 1}));
    const Image picture = render(scene, pixel_camera(64, 1), 64, 1);
    for (int x = 28; x < 36; ++x) EXPECT_NEAR(picture.at(x, 0, 0), 0.0f, 1e-3f) << x;
    EXPECT_NEAR(picture.at(0, 0, 0), 1.0f, 1e-3f);
}

TEST_F(FirstSampleTest, FootprintsStopAtMaterialEdges) {
    // One texel a sample, 4 x 4 samples a pixel. The first sample stands in column 2 of 4. Left of
    // x = 8.5 the texture is black, right of it white, and the first sample of pixel 8 is white.
    for (const bool edge : {true, false}) {
        Scene scene;
        Material material = unlit_material();
        material.base_color_texture.image = add_image(scene, 64, 32,
            [](int x, int) { return x < 34 ? glm::u8vec4(0, 0, 0, 255) : glm::u8vec4(255); });
        scene.materials = {material, unlit_material(glm::vec3(0.5f))};
        add(scene, rectangle({0, 0, 0}, {16, 0, 0}, {0, 8, 0}));
        if (edge) add(scene, rectangle({0, 0, 1}, {8.5f, 0, 0}, {0, 8, 0}, 1));
        const Image s = render_s(scene, pixel_camera(16, 8), 16, 8, 4);
        for (int y = 0; y < 8; ++y) {
            if (edge) {
                EXPECT_GT(s.at(8, y, 0), 0.999f) << "nothing bleeds across the edge";
            } else {
                EXPECT_LT(s.at(8, y, 0), 0.8f) << "without an edge the whole pixel is filtered";
            }
            EXPECT_NEAR(s.at(6, y, 0), edge ? 0.5f : 0.0f, 0.01f);
            EXPECT_NEAR(s.at(10, y, 0), 1.0f, 0.01f);
        }
    }
}

TEST_F(FirstSampleTest, FootprintsStopAtMaterialEdgesOneSampleAway) {
    // As above, mirrored: column 3 alone belongs to the other material, right of x = 8.75.
    Scene scene;
    Material material = unlit_material();
    material.base_color_texture.image = add_image(scene, 64, 32,
        [](int x, int) { return x < 35 ? glm::u8vec4(255) : glm::u8vec4(0, 0, 0, 255); });
    scene.materials = {material, unlit_material(glm::vec3(0.5f))};
    add(scene, rectangle({0, 0, 0}, {16, 0, 0}, {0, 8, 0}));
    add(scene, rectangle({8.75f, 0, 1}, {7.25f, 0, 0}, {0, 8, 0}, 1));
    const Image s = render_s(scene, pixel_camera(16, 8), 16, 8, 4);
    for (int y = 0; y < 8; ++y)
        EXPECT_GT(s.at(8, y, 0), 0.999f) << "nothing bleeds across the edge";
}

TEST_F(FirstSampleTest, FootprintsAreAsLargeAsTheirSurface) {
    // One texel a sample; rows of the texture are white up to 1.5 samples from the first one of
    // even pixels. Half of pixel column 8 has another material: a stratified first sample stands
    // for sqrt(8) rows, all white, and one of the whole pixel for 4, of which one is black.
    const int row = static_cast<int>(paper_order(4)[0]) / 4;
    Scene scene;
    Material material = unlit_material();
    material.base_color_texture.image = add_image(scene, 64, 32, [row](int, int y) {
        const int distance = (y - row + 36) % 8 - 4;
        return std::abs(distance) <= 1 ? glm::u8vec4(255) : glm::u8vec4(0, 0, 0, 255);
    });
    scene.materials = {material, unlit_material(glm::vec3(0.5f))};
    add(scene, rectangle({0, 0, 0}, {16, 0, 0}, {0, 8, 0}));
    add(scene, rectangle({0, 0, 1}, {8.5f, 0, 0}, {0, 8, 0}, 1));
    const Image prefix = render_s(scene, pixel_camera(16, 8), 16, 8, 4);
    const Image stratified = render_s(scene, pixel_camera(16, 8), 16, 8, 4, Resolve::stratified);
    for (int y = 0; y < 8; y += 2) {
        EXPECT_NEAR(prefix.at(8, y, 0), 0.75f, 0.02f) << y;
        EXPECT_GT(stratified.at(8, y, 0), 0.98f) << y;
        for (int x : {2, 7, 9, 14}) EXPECT_EQ(prefix.at(x, y, 0), stratified.at(x, y, 0));
    }
}

} // namespace
} // namespace ockham::test

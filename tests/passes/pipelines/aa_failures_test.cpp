// SPDX-License-Identifier: Apache-2.0
// Where adaptive anti-aliasing breaks: edges, wires, planes, decals, dots, steps of luma. Each test
// builds the input in code, shows the paper's method fail on it, and demands the right answer of
// ours. The numbers of the rows are those of docs/testing.md; scenes with textures and shadows are
// in aa_failures_scenes_test.cpp.
#include "tests/passes/pipelines/aa_failures.hpp"

#include <numbers>
#include <vector>

namespace ockham::test {
namespace {

/// The part of a convex polygon on the inner side of a line: dot(p, normal) <= offset.
std::vector<glm::dvec2> clipped(
    const std::vector<glm::dvec2>& polygon, glm::dvec2 normal, double offset) {
    std::vector<glm::dvec2> inside;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const glm::dvec2 a = polygon[i], b = polygon[(i + 1) % polygon.size()];
        const double da = glm::dot(a, normal) - offset, db = glm::dot(b, normal) - offset;
        if (da <= 0) inside.push_back(a);
        if ((da < 0) != (db < 0)) inside.push_back(a + (b - a) * (da / (da - db)));
    }
    return inside;
}

/// A flat convex polygon at height z, counter-clockwise, facing the camera.
Primitive polygon(const std::vector<glm::dvec2>& corners, float z, int material) {
    Primitive p;
    for (const glm::dvec2& corner : corners) p.positions.emplace_back(corner, z);
    p.normals.assign(corners.size(), glm::vec3(0, 0, 1));
    for (std::uint32_t i = 2; i < corners.size(); ++i)
        p.indices.insert(p.indices.end(), {0, i - 1, i});
    p.material = material;
    return p;
}

/// A bar of this width through `middle`, `degrees` from horizontal.
std::vector<glm::dvec2> bar(glm::dvec2 middle, double degrees, double length, double width) {
    const double angle = degrees * std::numbers::pi / 180;
    const glm::dvec2 along = 0.5 * length * glm::dvec2(std::cos(angle), std::sin(angle));
    const glm::dvec2 across = 0.5 * width * glm::dvec2(-std::sin(angle), std::cos(angle));
    return {middle - along - across, middle + along - across, middle + along + across,
        middle - along + across};
}

// Row 1: an edge at 19 angles and 4 offsets, one cell of 6 x 6 pixels each.
constexpr int kCell = 6;

Scene edges() {
    Scene scene;
    scene.materials = {unlit_material(), unlit_material(glm::vec3(0.0f))};
    for (int angle = 0; angle < 19; ++angle) {
        for (int offset = 0; offset < 4; ++offset) {
            const glm::dvec2 low(kCell * angle, kCell * offset), high = low + double(kCell);
            const std::vector<glm::dvec2> cell{low, {high.x, low.y}, high, {low.x, high.y}};
            const double a = angle * 5 * std::numbers::pi / 180;
            const glm::dvec2 normal(std::cos(a), std::sin(a));
            const double place = glm::dot(low + 0.5 * kCell, normal) + offset / 4.0 + 1e-3;
            add(scene, polygon(clipped(cell, normal, place), 0.0f, 0));
            add(scene, polygon(clipped(cell, -normal, -place), 0.0f, 1));
        }
    }
    return scene;
}

TEST_F(AaFailures, EdgesOfTwoColours) {
    const LitScene lit(device(), edges());
    const Camera camera = pixel_camera(19 * kCell, 4 * kCell);
    const Image full = render(lit, camera, all_samples(19 * kCell, 4 * kCell)).radiance;
    AdaptiveAaParams p = paper(19 * kCell, 4 * kCell);
    p.method = AaMethod::uniform;
    p.k = 2;
    const float two = largest_error(render(lit, camera, p).radiance, full);
    EXPECT_GT(two, 0.3f) << "a prefix of two samples knows coverage by halves";
    EXPECT_LE(two, 0.5f);
    const Picture better = render(lit, camera, ours(19 * kCell, 4 * kCell));
    EXPECT_LT(largest_error(better.radiance, full), 1e-6f) << "each surface by its coverage";
    EXPECT_EQ(better.most(), 2);
    p.k = 16;
    EXPECT_EQ(largest_error(render(lit, camera, p).radiance, full), 0.0f);
}

// Row 2: wires of 0.05 to 2 pixels, turned.
TEST_F(AaFailures, WiresThinnerThanAPixel) {
    constexpr int kSize = 64;
    Scene scene;
    scene.materials = {unlit_material()};
    const double widths[] = {0.05, 0.1, 0.2, 0.3, 0.5, 0.8, 1.2, 2.0};
    for (int i = 0; i < 8; ++i)
        add(scene, polygon(bar({32, 4 + 8 * i}, 13, 56, widths[i]), 0.0f, 0));
    const LitScene lit(device(), scene);
    const Camera camera = pixel_camera(kSize, kSize);
    const Image full = render(lit, camera, all_samples(kSize, kSize)).radiance;
    AdaptiveAaParams p = paper(kSize, kSize);
    const Picture geometric = render(lit, camera, p);
    p.metrics.depth_weight = p.metrics.normal_weight = 0;
    const Picture blind = render(lit, camera, p);
    const Picture better = render(lit, camera, ours(kSize, kSize));
    int holes = 0, wires = 0;
    for (int y = 0; y < kSize; ++y) {
        for (int x = 0; x < kSize; ++x) {
            const float cover = full.at(x, y, 3);
            if (cover == 0.0f || cover == 1.0f) continue;
            ++wires;
            EXPECT_GT(geometric.k(x, y), 1) << x << ", " << y;
            EXPECT_GT(better.k(x, y), 1) << x << ", " << y;
            holes += blind.k(x, y) == 1;
        }
    }
    EXPECT_GT(wires, 400);
    EXPECT_GT(holes, wires / 10) << "S alone misses what none of its samples hits";
}

// What no sample of the window hits, no method sees: a limit of m x m itself.
TEST_F(AaFailures, WiresBetweenTheSamplesAreMissedByAllOfThem) {
    constexpr int kWires = 60;
    Scene scene;
    scene.materials = {unlit_material()};
    for (int i = 0; i < kWires; ++i) { // the golden section: places in the pixel, evenly
        const double place = i + std::fmod(0.61803398875 * i, 1.0);
        add(scene, polygon(bar({8, place}, 0, 16, 0.05), 0.0f, 0));
    }
    const LitScene lit(device(), scene);
    const Camera camera = pixel_camera(16, kWires);
    const auto hit_rows = [](const Image& image) {
        int rows = 0;
        for (int y = 0; y < image.height(); ++y) rows += image.at(8, y, 3) > 0.0f;
        return rows;
    };
    EXPECT_NEAR(hit_rows(render(lit, camera, all_samples(16, kWires)).radiance), 0.2 * kWires, 4);
    EXPECT_NEAR(hit_rows(truth(lit, camera, 16, kWires)), 0.8 * kWires, 4);
}

// Rows 4 and 10: planes without an edge, at any angle, distance and scale of the scene.
struct Plane {
    float distance, degrees;
};
constexpr Plane kPlanes[] = {{5, 0}, {5, 45}, {5, 85}, {50, 45}, {50, 85}, {50, 89}, {5000, 85}};

Scene tilted_plane(Plane plane) {
    Scene scene;
    scene.materials = {unlit_material(glm::vec3(0.5f))};
    const float angle = plane.degrees * std::numbers::pi_v<float> / 180;
    const glm::vec3 up(0, std::cos(angle), -std::sin(angle)), across(1, 0, 0);
    const float half = plane.distance * 4;
    add(scene, rectangle(glm::vec3(0, 0, -plane.distance) - half * (up + across), 2 * half * across,
                   2 * half * up));
    return scene;
}

TEST_F(AaFailures, SlantedPlanes) {
    const Camera camera = look_at({0, 0, 0}, {0, 0, -1}, 0.5f); // far from the horizon
    for (const Plane plane : kPlanes) {
        SCOPED_TRACE(testing::Message() << plane.distance << " m, " << plane.degrees << " degrees");
        const Scene scene = tilted_plane(plane);
        EXPECT_EQ(render(scene, camera, ours(16, 16)).most(), 1);
        const int most = render(scene, camera, paper(16, 16)).most();
        if (plane.distance >= 50 && plane.degrees >= 89) {
            EXPECT_GT(most, 4) << "the variance of depth grows with slope and scale";
        }
        if (plane.distance >= 5000) {
            EXPECT_EQ(most, 16);
        }
    }
}

TEST_F(AaFailures, PlanesParallelToThePicture) {
    int paper_most = 1;
    for (const float distance : {1.0f, 30.0f, 1000.0f, 1e4f, 1e6f}) {
        SCOPED_TRACE(distance);
        Scene scene;
        scene.materials = {unlit_material(glm::vec3(0.5f))};
        add(scene, rectangle({-distance, -distance, -distance}, {2 * distance, 0, 0},
                       {0, 2 * distance, 0}));
        const Camera camera = look_at({0, 0, 0}, {0, 0, -1}, 60);
        EXPECT_EQ(render(scene, camera, ours(16, 16, 3)).most(), 1);
        paper_most = std::max(paper_most, render(scene, camera, paper(16, 16, 3)).most());
    }
    EXPECT_EQ(paper_most, 9) << "sums of squares lose the last bits";
}

// Row 9: a silhouette before a background of its own colour needs nothing, of another one two.
TEST_F(AaFailures, SilhouettesBeforeTheSky) {
    for (const float sky : {0.5f, 1.0f}) {
        Scene scene;
        scene.background = glm::vec3(sky);
        scene.materials = {unlit_material(glm::vec3(0.5f))};
        add(scene, polygon(bar({16, 16}, 20, 20, 10), 0.0f, 0));
        const Camera camera = pixel_camera(32, 32);
        const Picture picture = render(scene, camera, ours(32, 32));
        const Image full = render(scene, camera, all_samples(32, 32)).radiance;
        int edge = 0;
        for (int y = 0; y < 32; ++y) {
            for (int x = 0; x < 32; ++x) {
                const bool both = full.at(x, y, 3) > 0.0f && full.at(x, y, 3) < 1.0f;
                edge += both;
                ASSERT_TRUE(std::isfinite(picture.radiance.at(x, y, 1)));
                if (!both) {
                    EXPECT_EQ(picture.k(x, y), 1) << x << ", " << y;
                } else if (sky > 0.5f) {
                    EXPECT_GE(picture.k(x, y), 2) << x << ", " << y;
                }
            }
        }
        EXPECT_GT(edge, 40);
    }
}

// Row 5: two materials in one plane, each half of every pixel.
Scene stripes(const Material& even, const Material& odd, int width, int height) {
    Scene scene;
    scene.materials = {even, odd};
    for (int x = 0; x < width; ++x) {
        const glm::vec3 up(0, height, 0), across(0.5f, 0, 0);
        const auto left = static_cast<float>(x);
        add(scene, rectangle({left, 0, 0}, across, up, 0));
        add(scene, rectangle({left + 0.5f, 0, 0}, across, up, 1));
    }
    return scene;
}

TEST_F(AaFailures, CoplanarMaterials) {
    const Scene scene = stripes(unlit_material(), unlit_material(glm::vec3(0.0f)), 16, 16);
    const LitScene lit(device(), scene);
    const Camera camera = pixel_camera(16, 16);
    const Image full = render(lit, camera, all_samples(16, 16)).radiance;
    EXPECT_EQ(full.at(8, 8, 1), 0.5f);
    const Picture picture = render(lit, camera, paper(16, 16));
    EXPECT_EQ(picture.most(), 1) << "one depth, one normal, and S sees one of the two everywhere";
    EXPECT_EQ(largest_error(picture.radiance, full), 0.5f);
    const Picture better = render(lit, camera, ours(16, 16));
    for (const float k : better.counts.plane(0)) EXPECT_GE(k, 2.0f) << "two materials";
    EXPECT_LT(largest_error(better.radiance, full), 1e-6f);
}

// Row 11: 5 cm apart at 1 km, in a scene that reaches to 1,000 km.
TEST_F(AaFailures, NearAndFarPlanes) {
    Scene scene;
    scene.materials = {unlit_material(), unlit_material(glm::vec3(0.0f))};
    constexpr float kFront = -1000.0f, kBack = -1000.05f;
    add(scene, rectangle({-900, -900, kBack}, {1800, 0, 0}, {0, 1800, 0}, 1));
    add(scene, rectangle({-900, -900, kFront}, {900, 0, 0}, {0, 1800, 0}, 0));
    add(scene, rectangle({-1, 1e6f, -1e6f}, {2, 0, 0}, {0, 1, 0}, 1)); // far, out of sight
    const Camera camera = look_at({0, 0, 0}, {0, 0, -1}, 40);
    const Picture picture = render(scene, camera, paper(32, 32));
    for (int y = 0; y < 32; ++y) {
        EXPECT_EQ(picture.radiance.at(4, y, 1), 1.0f) << "the front plane hides the back one";
        EXPECT_EQ(picture.radiance.at(28, y, 1), 0.0f);
    }
    // fp32, near plane 1 m: what the depth buffer keeps of each plane.
    const auto standard = [](double z) {
        return static_cast<float>(1e6 / (1e6 - 1) * (1 - 1 / z));
    };
    const auto reversed = [](double z) { return static_cast<float>(1 / z); };
    EXPECT_EQ(standard(1000.0), standard(1000.05)) << "the usual depth cannot tell them apart";
    EXPECT_NE(reversed(1000.0), reversed(1000.05));
}

// Row 12: triangles without area, slivers, triangles below a sample.
TEST_F(AaFailures, DegenerateTrianglesCostNothing) {
    Scene scene;
    scene.materials = {unlit_material(glm::vec3(0.5f)), unlit_material()};
    add(scene, rectangle({0, 0, 0}, {32, 0, 0}, {0, 32, 0}, 0));
    const Camera camera = pixel_camera(32, 32);
    const int before = render(scene, camera, paper(32, 32)).most();
    add(scene, triangle({2, 2, 1}, {2, 2, 1}, {30, 30, 1}, 1));
    add(scene, triangle({2, 30, 1}, {16, 16, 1}, {30, 2, 1}, 1));
    add(scene, triangle({1, 1.2f, 1}, {31, 1.2f, 1}, {16, 1.2f + 1e-6f, 1}, 1)); // a sliver
    for (int i = 0; i < 30; ++i) { // between four samples
        const auto x = 1.0f + static_cast<float>(i);
        add(scene, triangle({x, 20, 1}, {x + 0.04f, 20, 1}, {x, 20.04f, 1}, 1));
    }
    const Picture after = render(scene, camera, paper(32, 32));
    EXPECT_EQ(before, 1);
    EXPECT_EQ(after.most(), 1);
    EXPECT_EQ(render(scene, camera, ours(32, 32)).most(), 1);
    for (const float v : after.radiance.plane(1)) ASSERT_EQ(v, 0.5f);
}

// Row 15: a dot of one sample's size with a radiance of 1000, in the plane of the wall.
TEST_F(AaFailures, BrightDotBelowAPixel) {
    Scene scene;
    scene.materials = {unlit_material(glm::vec3(0.25f)), unlit_material()};
    scene.materials[1].unlit = false;
    scene.materials[1].base_color = glm::vec4(0, 0, 0, 1);
    scene.materials[1].emissive = glm::vec3(1000.0f);
    // A frame around the dot's hole, so that the dot is in one plane with it: pixel (8, 8), and of
    // its 4 x 4 samples the one at (3, 0), which comes late in any order.
    const float left = 8.75f, low = 16 - 8 - 0.25f, size = 0.25f;
    add(scene, rectangle({0, 0, 0}, {left, 0, 0}, {0, 16, 0}));
    add(scene, rectangle({left + size, 0, 0}, {16 - left - size, 0, 0}, {0, 16, 0}));
    add(scene, rectangle({left, 0, 0}, {size, 0, 0}, {0, low, 0}));
    add(scene, rectangle({left, low + size, 0}, {size, 0, 0}, {0, 16 - low - size, 0}));
    add(scene, rectangle({left, low, 0}, {size, 0, 0}, {0, size, 0}, 1));
    const LitScene lit(device(), scene);
    const Camera camera = pixel_camera(16, 16);
    const float dot = 15 * 0.25f / 16 + 1000.0f / 16;
    const Image full = render(lit, camera, all_samples(16, 16)).radiance;
    EXPECT_NEAR(full.at(8, 8, 1), dot, 1e-3f)
        << "radiance is averaged before tone mapping; clamped first, it were 0.297";
    const Picture picture = render(lit, camera, paper(16, 16));
    EXPECT_EQ(picture.k(8, 8), 1) << "S is blind, depth and normals are flat";
    EXPECT_EQ(picture.radiance.at(8, 8, 1), 0.25f);
    const Picture better = render(lit, camera, ours(16, 16));
    EXPECT_GE(better.k(8, 8), 2) << "two materials";
    EXPECT_NEAR(better.radiance.at(8, 8, 1), dot, 1e-3f);
}

// Row 21: steps of luma through the middle of every pixel's window.
TEST_F(AaFailures, StepsOfLuma) {
    float last = 0;
    for (const float step : {0.02f, 0.06f, 0.12f, 0.2f}) {
        SCOPED_TRACE(step);
        // Radiance of display-encoded 0.8 and 0.8 + step, in stripes a pixel wide.
        const auto shade = [](float code) { return unlit_material(glm::vec3(srgb_decode(code))); };
        Scene scene;
        scene.materials = {shade(0.8f), shade(0.8f + step)};
        for (int x = 0; x < 16; ++x)
            add(scene, rectangle({float(x) - 0.5f, 0, 0}, {1, 0, 0}, {0, 16, 0}, x % 2));
        const LitScene lit(device(), scene);
        const Camera camera = pixel_camera(16, 16);
        const Image full = render(lit, camera, all_samples(16, 16)).radiance;
        const auto error = [&](const Image& image) {
            return std::abs(srgb_encode(image.at(8, 8, 1)) - srgb_encode(full.at(8, 8, 1)));
        };
        const Picture picture = render(lit, camera, paper(16, 16));
        const float edge = std::max(0.0312f, 0.125f * (0.8f + step));
        if (step < edge) {
            EXPECT_EQ(picture.k(8, 8), 1) << "dead zone";
            EXPECT_NEAR(error(picture.radiance), 0.5f * step, 0.1f * step);
            last = error(picture.radiance);
        } else {
            EXPECT_GT(picture.k(8, 8), 1);
        }
        const Picture better = render(lit, camera, ours(16, 16, 4, 1e-6f));
        EXPECT_GE(better.k(8, 8), 2) << "no dead zone";
        EXPECT_LT(error(better.radiance), 1e-5f);
    }
    EXPECT_GT(last, 0.025f) << "what the dead zone lets pass";
}

} // namespace
} // namespace ockham::test

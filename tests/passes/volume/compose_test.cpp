// SPDX-License-Identifier: Apache-2.0
// Composition along view rays: transmittance that no step length changes, order, furnaces, surfaces
// and what they hide, cuts, spacing, interruption. The cached light is one constant here, so that
// every picture has a closed form or a twin.
#include "framework/core/rng.hpp"
#include "passes/volume/cache.hpp"
#include "passes/volume/compose.hpp"
#include "tests/reference/compose.hpp"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/volume_bench.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ockham::test {
namespace {

using Pixels = std::vector<glm::vec4>;

/// Along +y, the box exactly fills the height of the picture.
Camera straight_camera() {
    Camera camera = look_at({0.0f, -2.0f, 0.0f}, glm::vec3(0.0f), 30.0f, UpAxis::z);
    camera.orthographic_height = 1.0f;
    return camera;
}

struct Scene {
    explicit Scene(Volume field) : volume(std::move(field)) {}
    Volume volume;
    TransferFunction transfer = linear_transfer();
    VolumeBench::Options options{.width = 16, .height = 16, .camera = straight_camera()};
    glm::vec3 light{0.0f};         ///< cached, everywhere; or:
    std::vector<glm::vec3> lights; ///< in layers along y, between which it is interpolated
    ComposeParams params;
    std::uint32_t executions = 1;
    std::vector<glm::vec2> surface_depth; ///< not empty: as add_surface_depth() would give it
};

/// The index of a cache whose cells lie in so many layers along y, a slot for each layer.
std::vector<std::uint32_t> layered_cache(glm::uvec3 dims, std::uint32_t layers) {
    shader::CacheHeader header{};
    header.cells = {layers, layers, layers};
    header.scale = std::max({dims.x, dims.y, dims.z}) / layers;
    header.format = CACHE_FP32;
    header.words = 3;
    header.slots = layers;
    std::vector<std::uint32_t> words(sizeof(header) / 4);
    std::memcpy(words.data(), &header, sizeof(header));
    for (std::uint32_t i = 0; i < layers * layers * layers; ++i)
        words.push_back(i / layers % layers);
    return words;
}

/// A scene on the device, to be executed as often as wanted.
class ComposeBench : public VolumeBench {
public:
    ComposeBench(gpu::Device& device, const Scene& scene)
        : VolumeBench(device, scene.volume, scene.transfer, scene.options) {
        std::vector<glm::vec3> lights = scene.lights;
        if (lights.empty()) lights = {scene.light};
        const auto layers = static_cast<std::uint32_t>(lights.size());
        ComposeInputs in{.medium = inputs,
            .cache_index = buffer("cache_index", layered_cache(scene.volume.dims, layers)),
            .cache_cells = buffer("cache_cells", lights)};
        ComposeParams params = scene.params;
        params.width = scene.options.width;
        params.height = scene.options.height;
        if (!scene.surface_depth.empty()) {
            in.surface_depth = image("surface_depth", VK_FORMAT_R32G32_SFLOAT, params.width,
                params.height, scene.surface_depth);
        }
        restart = graph.add_condition("restart");
        composed = add_compose(graph, in, params, restart);
        graph.export_resource(composed.picture, "test");
        graph.export_resource(composed.sum, "test");
        graph.export_resource(composed.count, "test");
    }
    void again() {
        execute();
        executor().set(restart, false);
    }
    Pixels pixels(ImageHandle image) {
        const std::vector<float> values = interleaved(read(image));
        Pixels result(values.size() / 4);
        std::memcpy(result.data(), values.data(), values.size() * sizeof(float));
        return result;
    }
    std::vector<std::uint32_t> counts() {
        const Image image = read(composed.count);
        const std::span<const float> plane = image.plane(0);
        return {plane.begin(), plane.end()};
    }
    Condition restart;
    Composed composed;
};

glm::dvec4 mean_of(const Pixels& pixels) {
    glm::dvec4 sum(0.0);
    for (const glm::vec4& p : pixels) sum += p;
    return sum / static_cast<double>(pixels.size());
}

class ComposeTest : public GpuTest {
protected:
    static Pixels compose(const Scene& scene) {
        ComposeBench bench(device(), scene);
        for (std::uint32_t i = 0; i < scene.executions; ++i) bench.again();
        return bench.pixels(bench.composed.picture);
    }
};

Volume constant_volume(glm::uvec3 dims) {
    return float_volume(dims, [](glm::uvec3) { return 1.0; });
}
Volume random_volume(glm::uvec3 dims, std::uint64_t seed) {
    Pcg32 rng(seed);
    return float_volume(dims, [&](glm::uvec3) { return rng.uniform(); });
}
/// Value 0 on a sphere around the centre of the box, more within; radius in world units.
Volume ball(std::uint32_t side, double radius) {
    return float_volume(glm::uvec3(side), [=](glm::uvec3 v) {
        const glm::dvec3 world = (glm::dvec3(v) + 0.5) / double(side) - 0.5;
        return radius - glm::length(world);
    });
}
TEST_F(ComposeTest, AHomogeneousMediumHasItsTransmittanceAtAnyStep) {
    // Linear opacity, sigma h, would give these instead: failures of the past.
    for (const auto& [n, linear] :
        {std::pair{8, .00391}, {16, .01002}, {64, .01608}, {300, .01783}}) {
        EXPECT_NEAR(std::pow(1.0 - 4.0 / n, n), linear, 1e-5);
    }
    Scene scene(constant_volume(glm::uvec3(16)));
    for (const float density : {0.01f, 1.0f, 4.0f, 6.0f}) {
        scene.options.view.density_scale = density;
        for (const float step : {0.05f, 0.3f, 1.0f, 7.0f, 1000.0f}) {
            scene.params = {.step_voxels = step, .step_depth = 1e6f};
            for (const glm::vec4& p : compose(scene))
                ASSERT_NEAR(p.a, 1.0 - std::exp(-double{density}), 3e-6) << density << ' ' << step;
        }
    }
}

TEST_F(ComposeTest, FrontToBackEqualsTheTwin) {
    // A random field along the rays; colour, opacity and emission of its own at each value.
    for (const std::uint64_t seed : {1u, 2u, 3u}) {
        Pcg32 rng(seed);
        std::vector<double> values(37);
        for (double& v : values) v = rng.uniform();
        std::fill(values.begin() + 7, values.begin() + 17, 0.0); // an empty cell
        Scene scene(float_volume({2, 37, 2}, [&](glm::uvec3 v) { return values[v.y]; }));
        scene.transfer.points = {
            {.value = 0, .opacity = 0, .color = {1, .2, .1}, .emission = {0, 0, 0}},
            {.value = .5, .opacity = .9, .color = {.2, .9, .4}, .emission = {3, 0, 1}},
            {.value = 1, .opacity = .3, .color = {.1, .3, 1}, .emission = {0, 2, 1}}};
        scene.options.view.density_scale = 5.0f;
        scene.options.view.environment = {.3f, .5f, .7f};
        scene.light = {.8f, .6f, .4f};
        scene.options.camera.orthographic_height = 0.01f;
        for (const float step : {0.25f, 1.0f, 3.0f}) {
            scene.params = {.step_voxels = step, .step_depth = 0.2f, .jitter = false};
            ComposeBench bench(device(), scene);
            bench.again();
            const Pixels pixels = bench.pixels(bench.composed.picture);

            std::vector<reference::RayCell> cells;
            for (std::uint32_t c = 0; c < 5; ++c) {
                const ValueRange range = reference::cell_ranges(scene.volume)[c];
                cells.push_back({std::min(8.0 * (c + 1) / 37, 1.0),
                    5.0 * reference::greatest_opacity(bench.gpu.table(), range)});
            }
            const TransferTable& table = bench.gpu.table();
            const auto medium = [&](double t) {
                const double value = scene.volume.sample({0.5, t, 0.5});
                const double place = (value - table.first) / (table.last - table.first) *
                                     double(table.entries.size() - 1);
                const auto entry =
                    std::min(static_cast<std::size_t>(place), table.entries.size() - 2);
                const double w = place - double(entry);
                const glm::dvec4 row = glm::mix(
                    glm::dvec4(table.entries[entry]), glm::dvec4(table.entries[entry + 1]), w);
                return reference::MediumPoint{5.0 * row.a, glm::dvec3(row),
                    glm::mix(glm::dvec3(table.emission[entry]),
                        glm::dvec3(table.emission[entry + 1]), w)};
            };
            const reference::Composed expected = reference::compose(
                cells, 0.0, medium, step / 37.0, 0.2f, scene.light, scene.options.view.environment);
            for (const glm::vec4& p : pixels) {
                ASSERT_NEAR(p.a, expected.alpha, 2e-5) << "step " << step;
                for (int c = 0; c < 3; ++c) ASSERT_NEAR(p[c], expected.radiance[c], 5e-5);
            }
        }
    }
}

/// Through the centre of a pixel: from the near to the far side of the box, in unit coordinates of
/// volumes that are cubes.
struct BoxRay {
    glm::dvec3 from, to;
    double length = 0; ///< world units, or unit ones
};
BoxRay box_ray(const shader::VolumeFrame& frame, std::size_t pixel) {
    const double x = (double(pixel % frame.size.x) + 0.5) / frame.size.x * 2 - 1;
    const double y = 1 - (double(pixel / frame.size.x) + 0.5) / frame.size.y * 2;
    const glm::dvec3 aside = x * glm::dvec3(frame.right) + y * glm::dvec3(frame.up);
    glm::dvec3 origin(frame.position), direction(frame.forward);
    (frame.orthographic ? origin : direction) += aside;
    direction = glm::normalize(direction);
    origin += 0.5;
    double near = 0, far = 1e9;
    for (int axis = 0; axis < 3; ++axis) {
        const double a = -origin[axis] / direction[axis], b = (1 - origin[axis]) / direction[axis];
        near = std::max(near, std::min(a, b));
        far = std::min(far, std::max(a, b));
    }
    if (!(near < far)) return {};
    return {origin + near * direction, origin + far * direction, far - near};
}
/// Mean value along it.
double mean_along(const Volume& volume, const BoxRay& ray) {
    constexpr int kSteps = 4000;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i)
        sum += volume.sample(glm::mix(ray.from, ray.to, (i + 0.5) / kSteps));
    return sum / kSteps;
}

/// Blocks of three voxels, by turns empty and full.
Volume checkerboard(std::uint32_t side) {
    return float_volume(glm::uvec3(side), [](glm::uvec3 v) {
        const glm::uvec3 block = v / 3u;
        return double((block.x + block.y + block.z) & 1u);
    });
}
Camera oblique_camera(float height) {
    Camera camera = look_at({1.3f, -2.1f, 0.7f}, {0.03f, 0.02f, 0.05f}, 30.0f, UpAxis::z);
    camera.orthographic_height = height;
    return camera;
}

TEST_F(ComposeTest, TheErrorOfACheckerboardFallsWithTheSquareOfTheStep) {
    Scene scene(checkerboard(24));
    scene.transfer = linear_transfer(glm::dvec3(0.5), glm::dvec3(1.0));
    scene.options.camera = oblique_camera(0.8f);
    scene.options.view.density_scale = 4.0f;
    scene.params.step_depth = 1e6f;
    scene.params.jitter = false;
    std::vector<double> exact;
    std::vector<double> errors;
    for (const float step : {2.0f, 1.0f, 0.5f, 0.25f, 0.125f, 0.0625f}) {
        scene.params.step_voxels = step;
        ComposeBench bench(device(), scene);
        bench.again();
        const Pixels pixels = bench.pixels(bench.composed.picture);
        double sum = 0;
        for (std::size_t i = 0; i < pixels.size(); ++i) {
            if (exact.size() == i) {
                const BoxRay ray = box_ray(bench.frame, i);
                exact.push_back(1 - std::exp(-4 * ray.length * mean_along(scene.volume, ray)));
            }
            sum += std::pow(pixels[i].a - exact[i], 2);
        }
        errors.push_back(std::sqrt(sum / double(pixels.size())));
    }
    EXPECT_GT(std::log2(errors.front() / errors.back()) / double(errors.size() - 1), 1.85);
    EXPECT_LT(errors[2], 6e-4); // at the default step
}

TEST_F(ComposeTest, JitteredStepsHaveABiasOfTheSameOrder) {
    // One ray, 4096 times: E[exp(-X)] > exp(-E[X]).
    Scene scene(checkerboard(24));
    scene.transfer = linear_transfer(glm::dvec3(0.5), glm::dvec3(1.0));
    scene.options.camera = oblique_camera(1e-5f);
    scene.options.width = scene.options.height = 64;
    scene.options.view.density_scale = 4.0f;
    scene.params.step_depth = 1e6f;
    scene.executions = 2;
    for (const float step : {2.0f, 1.0f, 0.5f, 0.25f}) {
        scene.params.step_voxels = step;
        ComposeBench bench(device(), scene);
        bench.again();
        const BoxRay ray = box_ray(bench.frame, 0);
        const double exact = std::exp(-4 * ray.length * mean_along(scene.volume, ray));
        double sum = 0, squares = 0;
        const Pixels pixels = bench.pixels(bench.composed.picture);
        for (const glm::vec4& p : pixels) {
            sum += 1.0 - p.a;
            squares += std::pow(1.0 - p.a, 2);
        }
        const auto n = double(pixels.size());
        const double mean = sum / n, error = std::sqrt((squares / n - mean * mean) / n);
        // alpha = 0.01 with Sidak over four steps: 3.02 standard errors.
        // alpha = 0.01 with Sidak over four steps: 3.02 standard errors.
        EXPECT_LT(std::abs(mean - exact), 3e-4 * step * step + 3.02 * error) << "step " << step;
    }
}

TEST_F(ComposeTest, FurnacesAreWhiteWhateverIsInThem) {
    // All that is seen, scattered in or emitted has radiance 1: so has every pixel.
    Scene scene(random_volume(glm::uvec3(20), 5));
    scene.transfer = {
        {{.value = 0.3, .opacity = 0, .color = {1, .5, .2}, .emission = glm::dvec3(1.0)},
            {.value = 1, .opacity = 1, .color = {.2, .4, 1}, .emission = glm::dvec3(1.0)}}};
    scene.light = glm::vec3(1.0f);
    scene.options.camera = volume_camera();
    for (const float density : {0.5f, 20.0f, 3000.0f}) {
        scene.options.view.density_scale = density;
        for (const glm::vec4& p : compose(scene)) {
            for (int c = 0; c < 3; ++c) ASSERT_NEAR(p[c], 1.0f, 2e-5f) << "density " << density;
            ASSERT_LE(p.a, 1.0f);
        }
    }
}

TEST_F(ComposeTest, LightThatVariesLinearlyIsSummedToSecondOrder) {
    // Cached light 1 up to y = 1/4, 3 from 3/4 on, linear between, in a medium that only scatters.
    Scene scene(constant_volume(glm::uvec3(16)));
    scene.lights = {glm::vec3(1.0f), glm::vec3(3.0f)};
    scene.options.view.density_scale = 2.0f;
    scene.options.view.environment = glm::vec3(0.0f);
    scene.params.jitter = false;
    double expected = 0;
    for (int i = 0; i < 10000; ++i) {
        const double t = (i + 0.5) / 10000;
        expected += 2e-4 * std::exp(-2 * t) * std::clamp(4 * t, 1.0, 3.0);
    }
    for (const glm::vec4& p : compose(scene)) ASSERT_NEAR(p.r, expected, 5e-4);
}

TEST_F(ComposeTest, AFurnaceIsWhiteWithTheLightThatPathsFind) {
    Scene scene(random_volume(glm::uvec3(12), 7));
    scene.transfer = {{{.value = 0.4, .opacity = 0}, {.value = 1, .opacity = 1}}};
    scene.options.camera = volume_camera();
    scene.options.view.density_scale = 10.0f;
    VolumeBench bench(device(), scene.volume, scene.transfer, scene.options);
    const gpu::Buffer frame(device(), gpu::BufferInfo{.bytes = sizeof(bench.frame),
                                          .usage = VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT,
                                          .name = "frame of the count",
                                          .memory = gpu::MemoryUse::upload});
    std::memcpy(frame.mapped().data(), &bench.frame, sizeof(bench.frame));
    CacheParams params;
    params.capacity = count_cache_cells(device(), bench.gpu, frame, params).slots;
    const Cache cache = add_cache(bench.graph, bench.inputs, params);
    const ComposeInputs in{
        .medium = bench.inputs, .cache_index = cache.index, .cache_cells = cache.cells};
    const Condition restart = bench.graph.add_condition("restart");
    const ImageHandle picture =
        add_compose(bench.graph, in, {.width = 16, .height = 16}, restart).picture;
    bench.graph.export_resource(picture, "test");
    for (int i = 0; i < 3; ++i) {
        bench.execute();
        set_cache_change(bench.executor(), cache, CacheChange::none);
    }
    const std::vector<float> values = interleaved(bench.read(picture));
    double opacity = 0;
    for (std::size_t i = 0; i < values.size(); i += 4) {
        for (std::size_t c = 0; c < 3; ++c) ASSERT_NEAR(values[i + c], 1.0f, 1e-3f); // of halves
        opacity += values[i + 3] / 256;
    }
    EXPECT_GT(opacity, 0.1);
}

TEST_F(ComposeTest, NothingShowsTheEnvironmentExactly) {
    Scene scene(random_volume(glm::uvec3(9, 17, 5), 6));
    scene.transfer = {{{.value = 0, .opacity = 0}, {.value = 1, .opacity = 0}}};
    scene.options.view.environment = {0.3f, 0.7f, 11.0f};
    for (const glm::vec4& p : compose(scene)) ASSERT_EQ(p, glm::vec4(0.3f, 0.7f, 11.0f, 0.0f));
}

TEST_F(ComposeTest, CutsAndCamerasInsideSeeWhatIsLeft) {
    Scene scene(constant_volume(glm::uvec3(16)));
    scene.options.view.density_scale = 3.0f;
    scene.params.jitter = false;

    scene.options.camera = look_at({0.1f, 0.2f, -0.1f}, {1.0f, 0.0f, 0.3f}, 70.0f, UpAxis::z);
    ComposeBench inside(device(), scene);
    inside.again();
    Pixels pixels = inside.pixels(inside.composed.picture);
    for (std::size_t i = 0; i < pixels.size(); ++i)
        ASSERT_NEAR(pixels[i].a, 1 - std::exp(-3 * box_ray(inside.frame, i).length), 3e-6);

    scene.options.camera = straight_camera();
    scene.options.view.crop_min = {0.0f, 0.25f, 0.0f};
    scene.options.view.crop_max = {0.5f, 0.6f, 1.0f};
    pixels = compose(scene);
    for (std::size_t i = 0; i < pixels.size(); ++i)
        ASSERT_NEAR(pixels[i].a, i % 16 < 8 ? 1 - std::exp(-3 * 0.35) : 0.0, 3e-6);

    scene.options.view.crop_min = glm::vec3(0.0f);
    scene.options.view.crop_max = glm::vec3(1.0f);
    scene.options.view.clip_planes = {{0.0f, 0.6f, 0.8f, 0.0f}}; // keeps y > -4/3 z
    pixels = compose(scene);
    for (std::size_t i = 0; i < pixels.size(); ++i) {
        const double z = 0.5 - (double(i / 16) + 0.5) / 16;
        const double length = std::clamp(0.5 + z * 4 / 3, 0.0, 1.0);
        ASSERT_NEAR(pixels[i].a, 1 - std::exp(-3 * length), 3e-6);
    }
}

TEST_F(ComposeTest, RaysAlongFacesAndEdgesAreFinite) {
    Scene scene(constant_volume(glm::uvec3(16)));
    scene.options.view.density_scale = 1.0f;
    scene.params.jitter = false;
    scene.options.camera.orthographic_height = 16.0f / 15.0f; // the outermost pixels: on the faces
    for (const glm::vec4& p : compose(scene))
        ASSERT_TRUE(std::abs(p.a) < 1e-6f || std::abs(p.a - 0.6321206f) < 1e-5f) << p.a;
    scene.options.width = scene.options.height = 15; // the middle column looks along a face
    scene.options.camera = look_at({0.5f, -2.0f, 0.0f}, {0.5f, 0.0f, 0.0f}, 30.0f, UpAxis::z);
    for (const glm::vec4& p : compose(scene)) ASSERT_TRUE(p.a >= 0 && p.a < 0.7f) << p.a;
}

TEST_F(ComposeTest, SpacingAndDirectionAreHonoured) {
    const auto value = [](glm::uvec3 v) {
        return 0.5 + 0.5 * std::sin(v.x * 0.7) * std::cos(v.y * 0.4);
    };
    Scene cubes(float_volume({24, 24, 24}, value)), slices(float_volume({24, 24, 6}, value));
    slices.volume.spacing_mm = {1, 1, 4};
    for (Scene* scene : {&cubes, &slices}) {
        scene->transfer = linear_transfer(glm::dvec3(0.5), glm::dvec3(1.0));
        scene->options.camera = oblique_camera(1.2f);
        scene->options.view.density_scale = 4.0f;
        scene->params.step_voxels = 0.25f;
        scene->params.jitter = false;
    }
    const Pixels a = compose(cubes), b = compose(slices);
    for (std::size_t i = 0; i < a.size(); ++i) ASSERT_NEAR(a[i].a, b[i].a, 1e-3);
    slices.volume.spacing_mm = {1, 1, 1}; // the test can fail
    EXPECT_GT(std::abs(mean_of(a).a - mean_of(compose(slices)).a), 0.05);

    // A quarter turn of data axes and camera about z.
    cubes.volume.direction = glm::dmat3({0, 1, 0}, {-1, 0, 0}, {0, 0, 1});
    cubes.options.camera =
        turned(cubes.options.camera, glm::vec3(0.0f), UpAxis::z, std::numbers::pi_v<float> / 2);
    const Pixels c = compose(cubes);
    for (std::size_t i = 0; i < a.size(); ++i) ASSERT_NEAR(a[i].a, c[i].a, 1e-4);
}

constexpr float kRadius = 0.35f;
constexpr float kBase = 0.8f;

/// A ball around which there is nothing but some fog in the corners of the box, seen from the front
/// where there is none.
Scene ball_scene(float opacity) {
    Scene scene(ball(32, kRadius));
    scene.transfer = {{{.value = -0.49, .opacity = 1}, {.value = -0.48, .opacity = 0}}};
    scene.options.width = scene.options.height = 32;
    scene.options.camera.orthographic_height = 0.75f;
    scene.options.view.surfaces = {{.value = 0, .opacity = opacity}};
    scene.options.view.environment = glm::vec3(0.0f);
    scene.params.jitter = false;
    return scene;
}
/// Outward normal at the front of a ball; z < 0 in the last place: the pixel misses it.
glm::dvec4 ball_normal(const Scene& scene, std::size_t pixel, double radius) {
    const double size = scene.options.width, height = scene.options.camera.orthographic_height;
    const double x = ((double(pixel % scene.options.width) + 0.5) / size - 0.5) * height;
    const double z = (0.5 - (double(pixel / scene.options.width) + 0.5) / size) * height;
    const double y2 = radius * radius - x * x - z * z;
    return {glm::dvec3(x, -std::sqrt(std::max(y2, 0.0)), z) / radius, y2 / (radius * radius)};
}

TEST_F(ComposeTest, OpaqueSurfacesAreShadedAndHideWhatIsBehind) {
    Scene scene = ball_scene(1.0f);
    scene.transfer.points.push_back({.value = 0.05, .opacity = 0});
    scene.transfer.points.push_back({.value = 0.06, .opacity = 1}); // within
    scene.light = glm::vec3(100.0f);
    scene.options.view.environment = {0.5f, 0.25f, 0.0f};
    scene.options.view.light_irradiance = glm::vec3(2.0f);
    for (const glm::vec3 travels : {glm::vec3(0, 1, 0), glm::vec3(1, 0, 0), glm::vec3(-1, 1, 0)}) {
        scene.options.view.light_direction = travels;
        const Pixels pixels = compose(scene);
        int seen = 0;
        for (std::size_t i = 0; i < pixels.size(); ++i) {
            const glm::dvec4 normal = ball_normal(scene, i, kRadius);
            const double cosine =
                -glm::dot(glm::dvec3(normal), glm::normalize(glm::dvec3(travels)));
            if (normal.w < -0.1) {
                ASSERT_EQ(pixels[i], glm::vec4(0.5f, 0.25f, 0.0f, 0.0f));
            }
            if (normal.w < 0.1 || std::abs(cosine) < 0.05) continue;
            ++seen;
            const double light = kBase / std::numbers::pi * 2.0 * std::max(cosine, 0.0);
            ASSERT_EQ(pixels[i].a, 1.0f);
            ASSERT_NEAR(pixels[i].r, light + kBase * 0.5, 6e-3);
            ASSERT_NEAR(pixels[i].g, light + kBase * 0.25, 6e-3);
            ASSERT_NEAR(pixels[i].b, light, 6e-3);
        }
        EXPECT_GT(seen, 400);
    }
}

TEST_F(ComposeTest, TranslucentSurfacesComposeAndShade) {
    Scene scene = ball_scene(0.5f);
    scene.options.view.environment = glm::vec3(1.0f);
    const Pixels shell = compose(scene);
    for (std::size_t i = 0; i < shell.size(); ++i) {
        if (ball_normal(scene, i, kRadius).w < 0.1) continue;
        ASSERT_FLOAT_EQ(shell[i].a, 0.75f); // in and out
        ASSERT_FLOAT_EQ(shell[i].r, 0.5f * kBase + 0.25f * kBase + 0.25f);
    }
    // An opaque core in a translucent shell, light from the camera: the shell dims it once.
    scene.options.view.environment = glm::vec3(0.0f);
    scene.options.view.light_direction = {0, 1, 0};
    scene.options.view.light_irradiance = glm::vec3(3.0f);
    scene.options.view.surfaces.push_back({.value = 0.15, .opacity = 1.0f});
    const Pixels core = compose(scene);
    for (std::size_t i = 0; i < core.size(); ++i) {
        const glm::dvec4 outer = ball_normal(scene, i, kRadius),
                         inner = ball_normal(scene, i, kRadius - 0.15);
        if (inner.w < 0.1) continue;
        ASSERT_EQ(core[i].a, 1.0f);
        const double expected =
            -(0.5 * outer.y + 0.5 * 0.5 * inner.y) * kBase / std::numbers::pi * 3;
        ASSERT_NEAR(core[i].r, expected, 1e-2);
    }
}

TEST_F(ComposeTest, TransmittanceFallsOnTheSurface) {
    // Fog of extinction 2 in front of a wall at y = 0.7, lit aslant through it.
    Scene scene(float_volume(glm::uvec3(16), [](glm::uvec3 v) { return (v.y + 0.5) / 16 - 0.7; }));
    scene.transfer = {{{.value = 0.1, .opacity = 0.5}, {.value = 0.2, .opacity = 1}}};
    scene.options.width = scene.options.height = 64;
    scene.options.camera.orthographic_height = 0.01f;
    scene.options.view.density_scale = 4.0f;
    scene.options.view.environment = glm::vec3(0.0f);
    scene.options.view.surfaces = {{.value = 0}};
    scene.options.view.light_direction = {0.3f, 1.0f, 0.0f};
    scene.options.view.light_irradiance = glm::vec3(4.0f);
    scene.params.samples = 16;
    const double slant = std::sqrt(1.09);
    const double expected =
        kBase / std::numbers::pi * 4 / slant * std::exp(-2 * 0.7) * std::exp(-2 * 0.7 * slant);
    double sum = 0, squares = 0;
    const Pixels pixels = compose(scene);
    for (const glm::vec4& p : pixels) {
        sum += p.r;
        squares += double(p.r) * p.r;
    }
    const auto n = double(pixels.size());
    const double error = std::sqrt((squares / n - sum / n * sum / n) / n);
    EXPECT_LT(std::abs(sum / n - expected), 2.576 * error) << sum / n << " for " << expected;
    EXPECT_LT(error, 0.01 * expected);
}

/// Fog, two translucent surfaces, a light: everything that may be interrupted.
Scene crowded_scene() {
    Scene scene(random_volume(glm::uvec3(16, 20, 12), 8));
    scene.options.camera = volume_camera();
    scene.options.view.density_scale = 6.0f;
    scene.options.view.environment = {0.4f, 0.5f, 0.6f};
    scene.options.view.surfaces = {
        {.value = 0.7, .opacity = 0.4f}, {.value = 0.8, .opacity = 0.6f}};
    scene.options.view.light_direction = {0.5f, 1.0f, -0.7f};
    scene.options.view.light_irradiance = glm::vec3(1.0f);
    scene.light = glm::vec3(0.5f, 0.4f, 0.3f);
    return scene;
}

TEST_F(ComposeTest, GainsAreLinear) {
    Scene scene = crowded_scene();
    const auto gained = [&](float surface, float volume) {
        scene.options.view.surface_gain = surface;
        scene.options.view.volume_gain = volume;
        return compose(scene);
    };
    const Pixels none = gained(0, 0), surface = gained(1, 0), volume = gained(0, 1),
                 both = gained(2, 3);
    EXPECT_GT(mean_of(surface).r, mean_of(none).r + 0.05);
    EXPECT_GT(mean_of(volume).r, mean_of(none).r + 0.05);
    for (std::size_t i = 0; i < both.size(); ++i) {
        const glm::vec4 sum =
            none[i] + 2.0f * (surface[i] - none[i]) + 3.0f * (volume[i] - none[i]);
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(both[i][c], sum[c], 1e-5f);
        ASSERT_EQ(both[i].a, none[i].a);
    }
}

TEST_F(ComposeTest, WhereABudgetEndsChangesNothing) {
    Scene scene = crowded_scene();
    ComposeBench whole(device(), scene);
    std::vector<Pixels> sums{Pixels(256, glm::vec4(0.0f))};
    for (int i = 0; i < 3; ++i) {
        whole.again();
        sums.push_back(whole.pixels(whole.composed.sum));
        for (const std::uint32_t count : whole.counts()) ASSERT_EQ(count, 2u * (i + 1u));
    }
    for (const std::uint32_t iterations : {1u, 7u, 60u}) {
        scene.params.iterations = iterations;
        scene.params.samples = 8; // passes
        ComposeBench pieces(device(), scene);
        std::uint32_t least = 0, interrupted = 0;
        for (int i = 0; i < 400 && least < 3; ++i) {
            pieces.again();
            const std::vector<std::uint32_t> counts = pieces.counts();
            const Pixels sum = pieces.pixels(pieces.composed.sum);
            const Pixels picture = pieces.pixels(pieces.composed.picture);
            least = ~0u;
            for (std::size_t p = 0; p < counts.size(); ++p) {
                const std::uint32_t samples = counts[p] / 2;
                least = std::min(least, samples);
                interrupted += counts[p] & 1u;
                if (samples <= 3) {
                    ASSERT_EQ(sum[p], sums[samples][p]) << iterations;
                }
                ASSERT_TRUE(picture[p].a >= 0 && picture[p].a <= 1 && picture[p].r < 10);
            }
        }
        EXPECT_GE(least, 3u);
        EXPECT_GT(interrupted, 0u);
    }
}

TEST_F(ComposeTest, SamplesAddUpUntilARestart) {
    Scene scene = crowded_scene();
    ComposeBench one(device(), scene);
    for (int i = 0; i < 3; ++i) one.again();
    scene.params.samples = 3;
    ComposeBench three(device(), scene);
    three.again();
    EXPECT_EQ(one.pixels(one.composed.sum), three.pixels(three.composed.sum));
    EXPECT_EQ(one.pixels(one.composed.picture), three.pixels(three.composed.picture));
    const Pixels first = three.pixels(three.composed.sum);
    three.again();
    EXPECT_NE(first, three.pixels(three.composed.sum));
    three.executor().set(three.restart, true);
    three.again();
    EXPECT_EQ(first, three.pixels(three.composed.sum));
}

TEST_F(ComposeTest, TheSearchedDepthIsTaken) {
    Scene scene = ball_scene(1.0f);
    scene.options.view.environment = {1.0f, 0.5f, 0.0f};
    // The left half: a surface in the middle of the box; the right: none, though the ball is there.
    for (std::uint32_t i = 0; i < 32 * 32; ++i)
        scene.surface_depth.emplace_back(0.5f, i % 32 < 16 ? 1.0f : 0.0f);
    const Pixels pixels = compose(scene);
    for (std::size_t i = 0; i < pixels.size(); ++i) {
        if (i % 32 < 16) {
            ASSERT_EQ(pixels[i], glm::vec4(kBase, 0.5f * kBase, 0.0f, 1.0f));
        } else {
            ASSERT_EQ(pixels[i], glm::vec4(1.0f, 0.5f, 0.0f, 0.0f));
        }
    }
}

} // namespace
} // namespace ockham::test

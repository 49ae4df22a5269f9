// SPDX-License-Identifier: Apache-2.0
// What the loupe shows of a pixel: samples whose mean the pixel is, their ranks and their number.
#include "framework/core/file.hpp"
#include "samples/viewer/subject.hpp"
#include "tests/support/gpu_fixture.hpp"

#include <algorithm>
#include <cmath>
#include <set>

namespace ockham::viewer {
namespace {

constexpr glm::uvec2 kSize{40, 30};

class ViewerLoupe : public test::GpuTest {
protected:
    ViewerLoupe() {
        std::filesystem::create_directories(folder);
        write_text(folder / "fog.raw", std::string(8 * 8 * 8, '\x7f'));
        write_text(folder / "fog.json",
            R"({"file": "fog.raw", "dims": [8, 8, 8], "type": "uint8", "spacing_mm": [1, 1, 1]})");
        write_text(folder / "even.json", R"({"points": [{"value": 0, "opacity": 1}]})");
    }
    ~ViewerLoupe() override { std::filesystem::remove_all(folder); }

    /// A plinth before a bright background, and fog before it that absorbs: by chance, or composed,
    /// which is exact where it is even.
    std::unique_ptr<Subject> open(Kind kind, const std::string& method, bool composed = false) {
        auto subject = std::make_unique<Subject>(kind);
        const std::string plinth = OCKHAM_SOURCE_DIR "/samples/surface_volume/plinth.gltf";
        SurfaceVolumeOptions& o = subject->options;
        o.surface.scene.scenes = {plinth};
        o.surface.method.method = method;
        o.surface.method.m = 3;
        o.world.inputs = {plinth, (folder / "fog.json").string()};
        o.world.environment = "0.5,0.7,0.9";
        o.world.place = "0.3,1,0.3 0,20,0 1.5";
        o.volume.volume.transfer = (folder / "even.json").string();
        o.volume.volume.density_scale = 1;
        o.volume.volume.albedo = 0;
        o.volume.steps = composed ? 1 : kSteps;
        o.volume.method.mode = composed ? "caching" : "path";
        o.volume.method.gather = !composed;
        subject->open(device());
        finish(*subject->technique);
        return subject;
    }
    static void finish(Technique& technique) {
        do technique.render(kSize, false);
        while (!technique.finished());
    }

    static constexpr int kSteps = 64;
    const std::filesystem::path folder =
        std::filesystem::temp_directory_path() / ("ockham_loupe." + std::to_string(::getpid()));
};

glm::vec3 mean(const SampleGrid& grid) {
    glm::vec3 sum(0.0f);
    for (const glm::vec3& radiance : grid.radiance) sum += radiance;
    return sum / static_cast<float>(grid.radiance.size());
}

float spread(const SampleGrid& grid) {
    const auto [low, high] = std::ranges::minmax(grid.radiance, {}, &glm::vec3::y);
    return high.y - low.y;
}

/// Standard error of a mean over pixels, of pictures and of grids whose random numbers are the same
/// in each. Paths are absorbed or not: each has a variance of 1/4 of its square at most.
double noise(double pixels, double steps, double paths) {
    return paths > 0 ? 0.5 * std::sqrt(1 / (steps * pixels) + 1 / (9 * paths)) : 0;
}

/// All that is known of some pixels agrees with their picture: one by one, and in the mean.
void expect_means(Technique& technique, double steps) {
    const Image picture = technique.picture();
    const float brightest = std::ranges::max(picture.plane(1));
    double difference = 0, pixels = 0, paths = 0;
    float widest = 0;
    for (int y = 1; y < picture.height(); y += 4) {
        for (int x = 1; x < picture.width(); x += 5, ++pixels) {
            const std::optional<SampleGrid> grid = technique.samples({x, y});
            ASSERT_TRUE(grid);
            EXPECT_EQ(grid->m, 3u);
            EXPECT_EQ(grid->count, 9u);
            widest = std::max(widest, spread(*grid));
            paths = static_cast<double>(grid->paths);
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(mean(*grid)[c], picture.at(x, y, c),
                    4.5 * noise(1, steps, paths) * brightest + 2e-5)
                    << x << " " << y;
            difference += mean(*grid).y - picture.at(x, y, 1);
        }
    }
    EXPECT_NEAR(difference / pixels, 0, 4 * noise(pixels, steps, paths) * brightest + 2e-5);
    EXPECT_GT(widest, 0.1f * brightest) << "no pixel sees more than one surface";
}

TEST_F(ViewerLoupe, SamplesHaveThePixelAsTheirMean) {
    for (const Kind kind : {Kind::surface, Kind::both}) {
        const std::unique_ptr<Subject> subject = open(kind, "ssaa");
        Technique& technique = *subject->technique;
        expect_means(technique, kSteps);
        EXPECT_EQ(technique.samples({20, 15})->paths > 0, kind == Kind::both);
        EXPECT_FALSE(technique.samples({40, 3})) << "beyond the picture";
    }
}

TEST_F(ViewerLoupe, CountsAreThoseOfTheOverlay) {
    const std::unique_ptr<Subject> subject = open(Kind::both, "adaptive");
    Technique& technique = *subject->technique;
    const std::optional<Overlay> counts = technique.overlay("k");
    ASSERT_TRUE(counts);
    std::set<std::uint32_t> seen;
    for (int y = 0; y < 30; y += 3) {
        for (int x = 0; x < 40; x += 3) {
            const std::optional<SampleGrid> grid = technique.samples({x, y});
            ASSERT_TRUE(grid);
            EXPECT_EQ(grid->count, static_cast<std::uint32_t>(counts->values.at(x, y, 0)));
            seen.insert(grid->count);
            std::vector<std::uint32_t> ranks = grid->ranks;
            std::ranges::sort(ranks);
            for (std::uint32_t i = 0; i < 9; ++i) EXPECT_EQ(ranks[i], i);
        }
    }
    EXPECT_GT(seen.size(), 1u);
}

TEST_F(ViewerLoupe, FollowsTheCameraAndTheMedium) {
    const std::unique_ptr<Subject> subject = open(Kind::both, "ssaa", true);
    Technique& technique = *subject->technique;
    const glm::ivec2 pixel(20, 15);
    float before = mean(*technique.samples(pixel)).y;
    const auto expect_another = [&](const char* what) {
        finish(technique);
        const float now = mean(*technique.samples(pixel)).y;
        EXPECT_NEAR(
            now, technique.picture().at(pixel.x, pixel.y, 1), 4.5 * 0.9 * noise(1, 1e9, 256) + 2e-5)
            << what;
        EXPECT_GT(std::abs(now - before), 0.1f) << what;
        before = now;
    };
    const Camera first = technique.stage().camera;
    Camera away = first;
    away.forward = -away.forward;
    technique.set_camera(away);
    expect_another("the camera");
    technique.set_camera(first);
    expect_another("the camera again");
    subject->options.volume.volume.density_scale = 60;
    technique.change({"density-scale"}); // nothing is left of the plinth
    expect_another("the density");
    dynamic_cast<SurfaceVolumeTechnique&>(technique).set_transfer(
        {{{.value = 0, .opacity = 0.01}, {.value = 255, .opacity = 0.01}}});
    expect_another("the transfer function");
    subject->options.surface.method.m = 2;
    technique.change({"m"});
    finish(technique);
    EXPECT_EQ(technique.samples(pixel)->radiance.size(), 4u);
}

TEST_F(ViewerLoupe, ShowsNothingWhereSamplesHaveNoPlace) {
    write_text(
        folder / "bare.gltf", R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{}]})");
    write_text(folder / "none.json", R"({"points": [{"value": 0, "opacity": 0}]})");
    struct Case {
        const char *input, *transfer, *method, *search;
        bool known;
    };
    const std::string plinth = OCKHAM_SOURCE_DIR "/samples/surface_volume/plinth.gltf",
                      bare = (folder / "bare.gltf").string();
    for (const Case& c : {Case{plinth.c_str(), "even.json", "none", "exact", true},
             Case{plinth.c_str(), "even.json", "none", "march", true},
             Case{plinth.c_str(), "none.json", "fxaa", "exact", false},
             Case{plinth.c_str(), "none.json", "ssaa", "exact", true},
             Case{bare.c_str(), "even.json", "none", "exact", false}}) {
        Subject subject(Kind::both);
        SurfaceVolumeOptions& o = subject.options;
        o.world.inputs = {c.input, (folder / "fog.json").string()};
        o.volume.volume.transfer = (folder / c.transfer).string();
        o.surface.method.method = c.method;
        o.volume.method.mode = "caching";
        o.volume.method.gather = false;
        o.volume.method.surface_search = c.search;
        o.volume.steps = 1;
        subject.open(device());
        subject.technique->render(kSize, false);
        EXPECT_EQ(bool(subject.technique->samples({20, 15})), c.known)
            << c.input << " " << c.transfer << " " << c.method << " " << c.search;
    }
}

} // namespace
} // namespace ockham::viewer

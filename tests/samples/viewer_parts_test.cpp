// SPDX-License-Identifier: Apache-2.0
// What the viewer is made of, without a window: cameras that are moved, sliders from declarations,
// what is shown of pictures, sizes in haste, what kind of thing a file is.
#include "framework/core/false_color.hpp"
#include "samples/viewer/cell_grid.hpp"
#include "samples/viewer/viewer.hpp"
#include "samples/viewer/widgets.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace ockham::viewer {
namespace {

float angle(glm::vec3 a, glm::vec3 b) { return std::acos(glm::clamp(glm::dot(a, b), -1.0f, 1.0f)); }

TEST(Navigation, OrbitsAroundThePivotAndStaysUpright) {
    for (const UpAxis up : {UpAxis::y, UpAxis::z}) {
        const glm::vec3 pivot(1, 2, 3),
            axis = up == UpAxis::y ? glm::vec3(0, 1, 0) : glm::vec3(0, 0, 1);
        Navigation navigation;
        navigation.reset(look_at({4, 5, 7}, pivot, 40, up), pivot, 2, up);
        const float distance = glm::distance(navigation.camera().position, pivot);
        for (int i = 0; i < 50; ++i) {
            navigation.orbit(0.3f, i % 2 ? 0.5f : -0.2f); // runs into the pole
            const Camera& c = navigation.camera();
            EXPECT_NEAR(glm::distance(c.position, pivot), distance, 1e-4f);
            EXPECT_LT(angle(c.forward, glm::normalize(pivot - c.position)), 1e-3f);
            EXPECT_NEAR(glm::length(c.up), 1.0f, 1e-5f);
            EXPECT_NEAR(glm::dot(c.up, c.forward), 0.0f, 1e-5f);
            EXPECT_GT(glm::dot(c.up, axis), 0.0f);
        }
    }
}

TEST(Navigation, OrbitTurnsByTheAngleAsked) {
    Navigation navigation;
    navigation.reset(look_at({0, 0, 5}, glm::vec3(0), 40), glm::vec3(0), 1, UpAxis::y);
    navigation.orbit(0.5f, 0);
    EXPECT_NEAR(angle(navigation.camera().forward, {0, 0, -1}), 0.5f, 1e-5f);
    EXPECT_GT(navigation.camera().forward.x, 0.0f); // to the right
    navigation.orbit(-0.5f, 0.25f);
    EXPECT_NEAR(navigation.camera().forward.y, std::sin(0.25f), 1e-5f);
}

TEST(Navigation, ZoomsTowardThePivotAndNeverThroughIt) {
    Navigation navigation;
    navigation.reset(look_at({0, 0, 5}, glm::vec3(0), 40), glm::vec3(0), 1, UpAxis::y);
    navigation.zoom(0.5f);
    EXPECT_NEAR(navigation.camera().position.z, 2.5f, 1e-6f);
    for (int i = 0; i < 100; ++i) navigation.zoom(0.5f);
    EXPECT_GT(navigation.camera().position.z, 0.0f);
}

TEST(Navigation, TheCameraAsTextIsTheCamera) {
    Navigation navigation;
    navigation.reset(look_at({1, 2, 3}, {0, 0, 0}, 35), glm::vec3(0), 1, UpAxis::y);
    navigation.orbit(0.7f, 0.1f);
    navigation.pan(0.2f, -0.1f);
    const Camera& c = navigation.camera();
    const std::optional<Camera> read =
        parse_camera(camera_text(c, navigation.distance()), UpAxis::y);
    ASSERT_TRUE(read.has_value());
    EXPECT_LT(glm::distance(read->position, c.position), 1e-4f);
    EXPECT_LT(angle(read->forward, c.forward), 1e-3f);
    EXPECT_EQ(read->fov_y_degrees, 35.0f);
}

TEST(SliderRange, ReachesWhatIsDeclaredOrWhatCanBeDraggedIn) {
    float share = 0.3f, price = 1.5e-5f, gain = 1;
    int m = 4, stall = 0;
    Params params;
    const SliderRange r = slider_range(params.add("share", &share, "").range(0, 1));
    EXPECT_EQ(r.low, 0);
    EXPECT_EQ(r.high, 1);
    EXPECT_FALSE(r.logarithmic);
    const SliderRange w = slider_range(params.add("m", &m, "").range(1, 8));
    EXPECT_EQ(w.low, 1);
    EXPECT_EQ(w.high, 8);
    const Param& lambda =
        params.add("lambda", &price, "").range(0, std::numeric_limits<double>::infinity());
    EXPECT_TRUE(slider_range(lambda).logarithmic);
    EXPECT_GT(slider_range(lambda).high, price);
    EXPECT_LT(slider_range(lambda).high, 1);
    price = 7; // typed
    EXPECT_EQ(slider_range(lambda).high, 7);
    price = std::numeric_limits<float>::infinity();
    EXPECT_TRUE(std::isfinite(slider_range(lambda).high));
    float none = 0;
    EXPECT_GE(slider_range(params.add("none", &none, "").range(0, 1e9)).high, 1);
    EXPECT_GE(slider_range(params.add("gain", &gain, "").range(0, 1e6)).high, 10);
    EXPECT_LE(slider_range(params.add("stall", &stall, "").range(0, 500000)).high, 500000);
}

Image flat(int width, int height, float value) {
    Image image(width, height, {"R", "G", "B", "A"});
    for (int c = 0; c < 4; ++c) std::ranges::fill(image.plane(c), value);
    return image;
}

TEST(Canvas, ShowsPicturesAsTheyAreWritten) {
    Image image = flat(3, 1, 0);
    const float values[] = {0.5f, 2.0f, std::numeric_limits<float>::quiet_NaN()};
    for (int x = 0; x < 3; ++x) image.at(x, 0, 0) = values[x];
    const Canvas canvas = compose(image, nullptr, nullptr, {});
    EXPECT_EQ(canvas.rgba[0], std::lround(255 * srgb_encode(0.5f)));
    EXPECT_EQ(canvas.rgba[4], 255);
    EXPECT_EQ(canvas.rgba[8], 0);
    const Canvas darker = compose(image, nullptr, nullptr, {.exposure = -1});
    EXPECT_EQ(darker.rgba[0], std::lround(255 * srgb_encode(0.25f)));
    EXPECT_NE(canvas.version, darker.version);
}

TEST(Canvas, WipesBetweenPicturesOfAnySize) {
    const Image black = flat(10, 2, 0), white = flat(5, 1, 1);
    const Canvas canvas = compose(black, &white, nullptr, {.wipe = 0.3f});
    for (int x = 0; x < 10; ++x)
        EXPECT_EQ(canvas.rgba[static_cast<std::size_t>(4 * x)], x < 3 ? 0 : 255) << x;
}

TEST(Canvas, LaysFalseColourOverTheLeftPicture) {
    const Image black = flat(4, 1, 0), white = flat(4, 1, 1);
    Overlay overlay{"k", "", Image(2, 1, {"k"}), 1, 16};
    overlay.values.at(0, 0, 0) = 1;
    overlay.values.at(1, 0, 0) = 16;
    const Canvas canvas = compose(black, &white, &overlay, {.wipe = 0.75f, .overlay = 1});
    const Rgb8 low = false_color(0), high = false_color(1);
    EXPECT_EQ(canvas.rgba[0], low.r);
    EXPECT_EQ(canvas.rgba[2 * 4 + 1], high.g);
    EXPECT_EQ(canvas.rgba[3 * 4], 255);
}

TEST(Canvas, CountsCodesOfDifference) {
    Image a = flat(2, 1, 0), b = flat(2, 1, 0);
    b.at(1, 0, 1) = 1;
    const Image error = code_error(a, b, {});
    EXPECT_EQ(error.at(0, 0, 0), 0);
    EXPECT_EQ(error.at(1, 0, 0), 255);
}

TEST(HurryScale, FindsPicturesThatAreFastEnough) {
    for (const double full : {30.0, 400.0, 2000.0, 20000.0}) { // ms of the whole picture
        HurryScale scale;
        const auto cost = [&] { return 10 + full / (scale.divisor() * scale.divisor()); };
        int late = 0; // frames
        for (int i = 0; i < 40; ++i) {
            late += cost() > 200;
            scale.add(cost());
        }
        EXPECT_LT(cost(), 200) << full;
        EXPECT_LE(late, 6) << full;
        const int settled = scale.divisor();
        for (int i = 0; i < 10; ++i) scale.add(cost());
        EXPECT_EQ(scale.divisor(), settled) << full;
        EXPECT_EQ(scale.median_ms(), cost()) << full;
        if (full == 30.0) {
            EXPECT_EQ(settled, 1);
        }
    }
}

TEST(HurryScale, ForgivesOneSlowFrame) {
    HurryScale scale;
    for (int i = 0; i < 20; ++i) {
        scale.add(3000); // compiled something
        scale.add(130);
    }
    EXPECT_EQ(scale.divisor(), 4);
}

TEST(TransferEditor, PointsKeepTheirOrderAndOpacityItsRange) {
    TransferFunction transfer{
        {{.value = 0, .opacity = 0}, {.value = 5, .opacity = 0.5}, {.value = 10, .opacity = 1}}};
    move_point(transfer, 1, 50, 2, 0, 20);
    EXPECT_EQ(transfer.points[1].value, 10);
    EXPECT_EQ(transfer.points[1].opacity, 1);
    move_point(transfer, 1, -3, -1, 0, 20);
    EXPECT_EQ(transfer.points[1].value, 0);
    EXPECT_EQ(transfer.points[1].opacity, 0);
    move_point(transfer, 2, 99, 0.25, 0, 20);
    EXPECT_EQ(transfer.points[2].value, 20);
    EXPECT_EQ(transfer.points[2].opacity, 0.25);
}

TEST(TransferEditor, FilesHoldWhatWasDrawn) {
    const TransferFunction drawn{{{.value = -1000.25, .opacity = 0},
        {.value = 1.0 / 3, .opacity = 0.7, .color = {0.1, 0.5, 1}, .emission = {2, 0, 3.5}}}};
    const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "drawn.json";
    save_transfer(file, drawn);
    const TransferFunction read = load_transfer(file);
    std::filesystem::remove(file);
    ASSERT_EQ(read.points.size(), drawn.points.size());
    for (std::size_t i = 0; i < read.points.size(); ++i) {
        EXPECT_EQ(read.points[i].value, drawn.points[i].value);
        EXPECT_EQ(read.points[i].opacity, drawn.points[i].opacity);
        EXPECT_EQ(read.points[i].color, drawn.points[i].color);
        EXPECT_EQ(read.points[i].emission, drawn.points[i].emission);
    }
}

/// A box of 1 x 1/2 x 1/2, 8 x 4 x 4 voxels.
CellGrid box(std::uint32_t side) {
    Volume volume;
    volume.dims = {8, 4, 4};
    return {place_of(volume), volume.dims, side};
}

TEST(CellGrid, RaysPassTheCellsInTheirWay) {
    const Camera camera = look_at({-3, 0.01f, 0.01f}, {0, 0.01f, 0.01f}, 1, UpAxis::z); // along x
    std::vector<std::size_t> passed;
    walk(box(2), camera, {1, 1}, {0, 0}, [&](std::size_t cell) {
        passed.push_back(cell);
        return true;
    });
    const std::size_t row = 1 * 4 + 1 * 4 * 2; // cells are 4 x 2 x 2; the upper half of y and z
    EXPECT_EQ(passed, (std::vector<std::size_t>{row, row + 1, row + 2, row + 3}));
    const Image counts =
        count_cells(box(2), camera, {1, 1}, [](std::size_t c) { return c % 2 == 0; });
    EXPECT_EQ(counts.at(0, 0, 0), 2);
}

TEST(CellGrid, PixelsLieWhereTheCameraPutsThem) {
    // From the front the box is a half as high as wide, and 1 wide at the distance 2.75 of its
    // front.
    const Camera camera = look_at({0, -3, 0}, {0, 0, 0}, 30, UpAxis::z);
    const Image counts = count_cells(box(4), camera, {101, 101}, [](std::size_t) { return true; });
    const double pixels = 101 / (2 * std::tan(glm::radians(15.0)) * 2.75);
    int wide = 0, high = 0;
    for (int i = 0; i < 101; ++i) {
        wide += counts.at(i, 50, 0) > 0;
        high += counts.at(50, i, 0) > 0;
    }
    EXPECT_NEAR(wide, pixels, 1.01);
    EXPECT_NEAR(high, 0.5 * pixels, 1.01);
    EXPECT_EQ(counts.at(50, 50, 0), 1); // 2 x 1 x 1 cells
    const Image colors = color_cells(box(4), camera, {101, 101}, [](std::size_t) { return true; });
    EXPECT_NE(colors.at(40, 50, 0), colors.at(60, 50, 0)); // left and right cell
    EXPECT_EQ(colors.at(40, 45, 1), colors.at(44, 55, 1));
    EXPECT_EQ(colors.at(0, 0, 0), 0);
}

TEST(Kinds, ComeFromNames) {
    EXPECT_EQ(kind_of({}), Kind::surface);
    EXPECT_EQ(kind_of({"a/b.gltf"}), Kind::surface);
    EXPECT_EQ(kind_of({"b.glb", "C.GLB"}), Kind::surface);
    EXPECT_EQ(kind_of({"builtin:wires"}), Kind::surface);
    EXPECT_EQ(kind_of({"builtin:cloud"}), Kind::volume);
    EXPECT_EQ(kind_of({"scan.nii.gz"}), Kind::volume);
    EXPECT_EQ(kind_of({"dicom_folder"}), Kind::volume);
    EXPECT_EQ(kind_of({"b.glb", "scan.nii.gz"}), Kind::both);
    EXPECT_EQ(kind_of({"builtin:cloud", "a/b.gltf", "c.glb"}), Kind::both);
}

TEST(Kinds, ValuesOfFlagsAreNoSources) {
    std::vector<std::string> words{"viewer", "--rig", "r.json", "--strict", "x.glb", "-o", "y.png",
        "--iso=300", "--transfer", "t.json"};
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    EXPECT_EQ(
        positionals(static_cast<int>(argv.size()), argv.data()), std::vector<std::string>{"x.glb"});
}

} // namespace
} // namespace ockham::viewer

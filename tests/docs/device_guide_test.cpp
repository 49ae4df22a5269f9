// SPDX-License-Identifier: Apache-2.0
// The code of README.md and of the guides that needs a device, run: see graph_guide_test.cpp.
#include "framework/core/error.hpp"
#include "framework/gpu/pipeline.hpp"
#include "framework/gpu/shader_folder.hpp"
#include "framework/runtime/commands.hpp"
#include "framework/runtime/executor.hpp"
// [image_error_includes]
#include "framework/image_error/image_error.hpp"
#include "framework/io/image_file.hpp"
// [/image_error_includes]
#include "tests/support/file_test.hpp"
#include "tests/support/gpu_fixture.hpp"

namespace ockham {
namespace {

TEST(DeviceGuide, Embed) {
    // [embed]
    Graph graph("hello");
    ImageHandle picture = graph.create_image(
        "picture", {.format = VK_FORMAT_R32_SFLOAT, .width = 640, .height = 480});
    PassBuilder draw = graph.add_compute_pass("draw_circle");
    picture = draw.write("picture", picture); // a new version of its content
    draw.record([](Commands& commands) {
        commands.dispatch_over({.shader = "samples/hello.comp"}, {640, 480, 1});
    });
    graph.export_resource(picture, "shown to the user"); // what nothing needs is culled

    gpu::Device device;                          // headless; the best by score
    Executor executor(device, std::move(graph)); // compiles once
    executor.execute();
    const Image result = executor.read(picture);
    // [/embed]
    EXPECT_EQ(result.width(), 640);
    EXPECT_EQ(result.plane(0)[0], 0.0f);               // a corner
    EXPECT_EQ(result.plane(0)[240 * 640 + 320], 1.0f); // the middle of the circle
}

class DeviceGuideFiles : public test::FileTest {};

TEST_F(DeviceGuideFiles, ImageError) {
    const auto fill = [](Image& image, float value) {
        for (int channel = 0; channel < 3; ++channel)
            for (float& texel : image.plane(channel)) texel = value;
    };
    Image dark(16, 16, {"R", "G", "B"}), bright(16, 16, {"R", "G", "B"});
    fill(dark, 0);
    fill(bright, 1);
    save_image(file("dark.exr"), dark);
    save_image(file("bright.exr"), bright);
    const std::string test = file("dark.exr"), reference = file("bright.exr");
    // [image_error]
    const ImageError error = image_error(load_image(test), load_image(reference));
    fmt::print("PSNR {:.2f} dB, FLIP {:.4f}\n", error.psnr, error.flip.mean);
    // [/image_error]
    EXPECT_EQ(error.mse, 1.0);
}

TEST_F(DeviceGuideFiles, Reload) {
    gpu::Device device;
    const std::filesystem::path folder = folder_;
    // [reload]
    device.pipelines().reload_from(std::make_unique<gpu::ShaderFolder>(folder)); // once
    device.pipelines().reload(); // between executions
    // [/reload]
    EXPECT_EQ(device.pipelines().count(), 0u);
}

} // namespace
} // namespace ockham

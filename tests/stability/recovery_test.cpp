// SPDX-License-Identifier: Apache-2.0
// After a failure the process goes on: out of memory leaves the device usable for a smaller job,
// and a lost device is replaced by a new one on which a saved state goes on, all bit for bit.
#include "framework/core/error.hpp"
#include "framework/scene/builtin.hpp"
#include "framework/scene/builtin_volume.hpp"
#include "passes/pipelines/adaptive_aa.hpp"
#include "passes/pipelines/volume_gi.hpp"
#include "tests/support/fault_layer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>

namespace ockham::test {
namespace {

class RecoveryTest : public testing::Test {
protected:
    RecoveryTest() { layer_.arm(""); }

    static gpu::DeviceOptions options() {
        gpu::DeviceOptions options;
        options.validation = gpu::Validation::core;
        if (const char* const gpu = std::getenv("OCKHAM_TEST_GPU")) options.gpu = gpu;
        return options;
    }
    /// Runs `statement` and returns the kind of the Error it ends on.
    template <class Statement>
    static std::optional<ErrorKind> failure_of(const Statement& statement) {
        try {
            statement();
        } catch (const Error& error) {
            return error.kind();
        }
        return {};
    }
    static void expect_equal(const Image& a, const Image& b) {
        ASSERT_EQ(a.channels(), b.channels());
        for (std::size_t c = 0; c < a.channels().size(); ++c) {
            EXPECT_TRUE(
                std::ranges::equal(a.plane(static_cast<int>(c)), b.plane(static_cast<int>(c))));
        }
    }

    FaultLayer layer_;
};

Image aa_picture(gpu::Device& device, const LitScene& scene, std::uint32_t side, std::uint32_t m) {
    AdaptiveAaParams params;
    params.width = params.height = side;
    params.m = m;
    AdaptiveAa aa(device, scene, scene.scene().cameras.front(), params);
    aa.execute();
    return aa.picture();
}

TEST_F(RecoveryTest, out_of_memory_leaves_the_device_to_a_smaller_job) {
    const auto lit = [](gpu::Device& device) { return LitScene(device, builtin_scene("fence")); };
    std::optional<Image> fresh;
    {
        gpu::Device device(options());
        fresh = aa_picture(device, lit(device), 24, 2);
    }
    gpu::Device device(options());
    const LitScene scene = lit(device);
    int failures = 0;
    for (const char* call : {"vkAllocateMemory", "vkCreateImage", "vkBindImageMemory",
             "vkCreateComputePipelines", "vkCreateFramebuffer", "vkQueueSubmit"}) {
        for (int n = 1; n <= 3; ++n) {
            layer_.arm(std::string(call) + ":" + std::to_string(n) + ":-2");
            const std::optional<ErrorKind> failure =
                failure_of([&] { aa_picture(device, scene, 64, 4); });
            if (!layer_.hit()) continue; // fewer calls than n
            EXPECT_EQ(failure, ErrorKind::device) << call << ", call " << n;
            ++failures;
            layer_.arm("");
            expect_equal(aa_picture(device, scene, 24, 2), *fresh);
        }
    }
    EXPECT_GE(failures, 8);
    EXPECT_TRUE(device.validation_messages().empty());
}

TEST_F(RecoveryTest, a_saved_state_goes_on_where_the_device_was_lost) {
    const Volume volume = builtin_volume("builtin:cloud", 16);
    const TransferFunction transfer = default_transfer(volume);
    const Camera camera = look_at({0, -2.4f, 0.2f}, {0, 0, 0}, 30, UpAxis::z);
    VolumeView view;
    view.density_scale = 10;
    VolumeGiParams params;
    params.width = params.height = 16;
    params.mode = VolumeMode::caching;
    const auto make = [&](gpu::Device& device) {
        return VolumeGi(device, volume, transfer, {}, view, camera, params);
    };
    constexpr int kSteps = 6;
    std::optional<Image> whole;
    {
        gpu::Device device(options());
        VolumeGi picture = make(device);
        for (int step = 0; step < kSteps; ++step) picture.execute();
        whole = picture.picture();
    }
    for (const char* call : {"vkQueueSubmit:2:-4", "vkWaitForFences:2:-4"}) {
        std::vector<SavedResource> saved;
        {
            gpu::Device device(options());
            VolumeGi picture = make(device);
            for (int step = 0; step < 3; ++step) picture.execute();
            saved = picture.save();
            layer_.arm(call);
            EXPECT_EQ(failure_of([&] {
                for (int step = 3; step < kSteps; ++step) picture.execute();
            }),
                ErrorKind::device);
            EXPECT_TRUE(layer_.hit()) << call;
            EXPECT_TRUE(device.validation_messages().empty());
        }
        layer_.arm("");
        gpu::Device device(options());
        VolumeGi picture = make(device);
        picture.restore(saved);
        for (int step = 3; step < kSteps; ++step) picture.execute();
        expect_equal(picture.picture(), *whole);
    }
}

} // namespace
} // namespace ockham::test

// SPDX-License-Identifier: Apache-2.0
#include "framework/core/rng.hpp"
#include "framework/runtime/commands.hpp"
#include "framework/scene_gpu/volume_gpu.hpp"
#include "tests/support/gpu_fixture.hpp"

#include <algorithm>
#include <cstring>

namespace ockham {
namespace {

template <class T>
Volume volume_of(VoxelType type, glm::uvec3 dims, const std::vector<T>& voxels) {
    Volume volume;
    volume.name = "test";
    volume.dims = dims;
    volume.type = type;
    const auto bytes = std::as_bytes(std::span(voxels));
    volume.voxels.assign(bytes.begin(), bytes.end());
    return volume;
}

TransferFunction ramp(glm::dvec3 emission = glm::dvec3(0.0)) {
    return {{{.value = 0, .opacity = 0, .emission = emission},
        {.value = 1000, .opacity = 1, .emission = emission}}};
}

class VolumeGpuTest : public test::GpuTest {
protected:
    /// Content of one of the buffers, through a graph.
    static std::vector<float> content(const VolumeGpu& gpu, BufferHandle VolumeHandles::*which) {
        Graph graph("read");
        const VolumeHandles handles = gpu.import(graph);
        const BufferDesc desc = graph.desc(handles.*which);
        PassBuilder pass = graph.add_compute_pass("copy");
        pass.read("from", handles.*which);
        const BufferHandle copied = pass.write("to", graph.create_buffer("copy", desc));
        pass.record([words = static_cast<std::uint32_t>(desc.bytes / 4)](Commands& commands) {
            commands.dispatch_over({.shader = "test/copy_buffer.comp"}, {words, 1, 1});
        });
        graph.export_resource(copied, "compared");
        Executor executor(device(), std::move(graph));
        gpu.bind(executor, handles);
        executor.execute();
        return test::read_as<float>(executor, copied);
    }
};

TEST_F(VolumeGpuTest, SaysWhatThereIs) {
    const Volume volume =
        volume_of<std::uint8_t>(VoxelType::uint8, {9, 1, 1}, {0, 10, 20, 30, 40, 50, 60, 70, 80});
    const VolumeGpu gpu(device(), volume, ramp());
    EXPECT_EQ(gpu.facts().dims, glm::uvec3(9, 1, 1));
    EXPECT_EQ(gpu.facts().cells, glm::uvec3(2, 1, 1));
    EXPECT_FALSE(gpu.facts().homogeneous);
    EXPECT_FALSE(gpu.facts().emission);
    EXPECT_FALSE(gpu.facts().environment_map);
    EXPECT_GT(gpu.max_opacity(), 0.08f); // by what rounding may need
    EXPECT_LT(gpu.max_opacity(), 0.08f * 1.000001f);
    Graph graph("test");
    const VolumeHandles handles = gpu.import(graph);
    const ImageDesc& image = graph.desc(handles.volume);
    const bool wide = device().info().software;
    EXPECT_EQ(image.format, wide ? VK_FORMAT_R16_UNORM : VK_FORMAT_R8_UNORM);
    EXPECT_EQ(glm::uvec3(image.width, image.height, image.depth), glm::uvec3(9, 1, 2));
    EXPECT_FALSE(handles.emission);
    EXPECT_FALSE(handles.environment);
    EXPECT_FALSE(handles.environment_table);
    // 81 codes of four floats, maxima of 1, 2, 4 ... 64 codes, the slice twice.
    EXPECT_EQ(gpu.bytes(), 81 * 16 + 7 * 81 * 4 + 2 * 9 * (wide ? 2u : 1u));
}

TEST_F(VolumeGpuTest, MaximaAreThoseOfRunsOfEntries) {
    Pcg32 rng(1);
    TransferFunction transfer;
    for (int i = 0; i <= 100; ++i) transfer.points.push_back({10.0 * i, rng.uniform()});
    const VolumeGpu gpu(
        device(), volume_of<std::uint16_t>(VoxelType::uint16, {2, 1, 1}, {100, 799}), transfer);
    const std::vector<glm::vec4>& entries = gpu.table().entries;
    ASSERT_EQ(entries.size(), 700u);
    const std::vector<float> levels = content(gpu, &VolumeHandles::opacity_max);
    ASSERT_EQ(levels.size(), 10 * entries.size()); // 1, 2, 4 ... 512
    for (std::size_t level = 0; level < 10; ++level) {
        for (std::size_t i = 0; i < entries.size(); ++i) {
            float greatest = 0;
            for (std::size_t k = i; k < std::min(i + (1u << level), entries.size()); ++k)
                greatest = std::max(greatest, entries[k].w);
            ASSERT_EQ(levels[level * entries.size() + i], greatest) << level << " " << i;
        }
    }
}

TEST_F(VolumeGpuTest, TellsWhenGraphsMustBeDeclaredAnew) {
    VolumeGpu gpu(device(),
        volume_of<std::int16_t>(VoxelType::int16, {2, 2, 1}, {-500, 0, 250, 500}), ramp());
    const std::uint64_t bytes = gpu.bytes();
    EXPECT_FALSE(gpu.set_transfer({{{0, 0}, {300, 1}}}));
    EXPECT_EQ(gpu.bytes(), bytes);
    EXPECT_EQ(content(gpu, &VolumeHandles::transfer)[4 * 600 + 3], gpu.table().entries[600].w);
    EXPECT_EQ(gpu.table().entries[800].w, 1.0f);              // the new function's
    EXPECT_TRUE(gpu.set_transfer(ramp(glm::dvec3(2, 1, 0)))); // it emits
    EXPECT_TRUE(gpu.facts().emission);
    EXPECT_EQ(content(gpu, &VolumeHandles::emission)[0], 2.0f);
    EXPECT_TRUE(gpu.set_transfer({{{0, 0.5}}})); // one opacity
    EXPECT_TRUE(gpu.facts().homogeneous);
    EXPECT_FALSE(gpu.facts().emission);
    EXPECT_TRUE(gpu.set_transfer(ramp()));
    EXPECT_EQ(gpu.bytes(), bytes);
}

TEST_F(VolumeGpuTest, IsHomogeneousWhereOpacityIs) {
    const auto homogeneous = [](const TransferFunction& transfer) {
        return VolumeGpu(
            device(), volume_of<float>(VoxelType::float32, {2, 1, 1}, {1, 2}), transfer)
            .facts()
            .homogeneous;
    };
    EXPECT_TRUE(homogeneous({{{0, 0.5}}}));
    EXPECT_FALSE(homogeneous({{{1, 0.5}, {2, 0.6}}}));
    // Differs only beyond the values that occur.
    EXPECT_TRUE(homogeneous({{{0, 0}, {0.5, 0.5}, {2.5, 0.5}, {3, 0}}}));
    // The same opacity at both extremes, but not between them.
    EXPECT_FALSE(homogeneous({{{1, 0}, {1.5, 1}, {2, 0}}}));
}

TEST_F(VolumeGpuTest, TooLargeForTheDeviceIsSaidWithNumbers) {
    const Volume volume = volume_of<std::uint8_t>(VoxelType::uint8, {2, 1, 1}, {0, 1});
    const std::string text = test::error_of([&] {
        VolumeGpu(device(), volume, ramp(), Image(60'000, 1, {"R", "G", "B"}));
    });
    EXPECT_NE(text.find("image 'environment' of 60000 x 1"), std::string::npos) << text;
    EXPECT_NE(text.find("the device allows"), std::string::npos) << text;
}

TEST_F(VolumeGpuTest, TooLongForTheWalkThroughCellsIsSaidWithNumbers) {
    const Volume volume =
        volume_of<std::uint8_t>(VoxelType::uint8, {1, 8177, 1}, std::vector<std::uint8_t>(8177));
    const std::string text = test::error_of([&] { VolumeGpu(device(), volume, ramp()); });
    EXPECT_NE(text.find("8177 voxels along y"), std::string::npos) << text;
    EXPECT_NE(text.find("at most 8176"), std::string::npos) << text;
}

} // namespace
} // namespace ockham

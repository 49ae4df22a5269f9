// SPDX-License-Identifier: Apache-2.0
#include "framework/core/rng.hpp"
#include "framework/runtime/commands.hpp"
#include "passes/volume/frame.hpp"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/volume_bench.hpp"

#include <cmath>
#include <cstring>

namespace ockham {
namespace {

Volume noise(glm::uvec3 dims, VoxelType type) {
    Volume volume = test::float_volume(dims, [](glm::uvec3) { return 0; });
    volume.type = type;
    volume.value_scale = 2;
    volume.value_offset = 10;
    volume.voxels.resize(volume.voxel_count() * bytes_of(type));
    Pcg32 rng(21);
    for (std::size_t i = 0; i < volume.voxels.size(); i += bytes_of(type)) {
        const std::uint32_t code = rng.next();
        const float real = rng.uniform(-50, 50);
        std::memcpy(&volume.voxels[i],
            type == VoxelType::float32 ? static_cast<const void*>(&real)
                                       : static_cast<const void*>(&code),
            bytes_of(type));
    }
    return volume;
}

/// Opacity varies, so that there is a grid of majorants.
TransferFunction ramp_over(const Volume& volume) {
    const ValueRange range = value_range(volume);
    return {{{range.lowest, 0}, {range.highest, 1}}};
}

class VolumeFrameTest : public test::GpuTest {
protected:
    /// The field at places, as kernels see it.
    static std::vector<float> fields(
        test::VolumeBench& bench, const std::vector<glm::vec3>& places) {
        struct Probe {
            float field, sigma_t, majorant;
            std::uint32_t cell;
        };
        const BufferHandle input = bench.buffer("places", places);
        PassBuilder pass = bench.graph.add_compute_pass("probe");
        read_medium(pass, bench.inputs, {.light = false, .surfaces = false});
        pass.read("places", input);
        const BufferHandle output = pass.write(
            "probes", bench.graph.create_buffer("probes", {places.size() * sizeof(Probe)}));
        pass.record([count = static_cast<std::uint32_t>(places.size())](Commands& commands) {
            commands.dispatch_over({.shader = "test/probe.comp:grid"}, {count, 1, 1});
        });
        bench.graph.export_resource(output, "compared");
        bench.execute();
        std::vector<float> result;
        for (const Probe& probe : bench.read<Probe>(output)) result.push_back(probe.field);
        return result;
    }

    static shader::VolumeFrame frame_of(
        const Volume& volume, const VolumeView& view, const Camera& camera = volume_camera()) {
        const VolumeGpu gpu(device(), volume, test::linear_transfer());
        return make_volume_frame(place_of(volume), gpu, camera, 64, 64, view);
    }
};

TEST_F(VolumeFrameTest, LookupsAreTrilinearBetweenVoxelCentres) {
    const glm::uvec3 dims(13, 8, 5);
    std::vector<glm::vec3> places;
    Pcg32 rng(22);
    for (int i = 0; i < 20'000; ++i)
        places.emplace_back(rng.uniform(), rng.uniform(), rng.uniform());
    for (std::uint32_t i = 0; i < dims.x * dims.y * dims.z; ++i) { // centres
        const glm::vec3 voxel(i % dims.x, i / dims.x % dims.y, i / (dims.x * dims.y));
        places.push_back((voxel + 0.5f) / glm::vec3(dims));
    }
    for (const VoxelType type :
        {VoxelType::uint8, VoxelType::uint16, VoxelType::int16, VoxelType::float32}) {
        const Volume volume = noise(dims, type);
        test::VolumeBench bench(device(), volume, ramp_over(volume), {});
        const std::vector<float> found = fields(bench, places);
        const ValueRange range = value_range(volume);
        const double extent =
            double{bench.gpu.texel_of(range.highest)} - double{bench.gpu.texel_of(range.lowest)};
        double worst = 0;
        for (std::size_t i = 0; i < places.size(); ++i) {
            const double exact = double{bench.gpu.texel_of(volume.sample(glm::dvec3(places[i])))};
            worst = std::max(worst, std::abs(double{found[i]} - exact) / extent);
        }
        // Hardware has 8 bits for the place between two texels of each axis.
        EXPECT_LT(worst, device().info().software ? 1e-6 : 3.0 / 512) << name_of(type);
    }
}

TEST_F(VolumeFrameTest, AVolumeOneVoxelThinIsConstantAcross) {
    for (const glm::uvec3 dims : {glm::uvec3(5, 4, 1), glm::uvec3(1, 1, 6)}) {
        const Volume volume = noise(dims, VoxelType::float32);
        test::VolumeBench bench(device(), volume, ramp_over(volume), {});
        const std::vector<glm::vec3> places{
            {0.3f, 0.4f, 0.1f}, {0.3f, 0.4f, 0.5f}, {0.3f, 0.4f, 0.9f}};
        const std::vector<float> found = fields(bench, places);
        for (std::size_t i = 0; i < places.size(); ++i)
            EXPECT_NEAR(double{found[i]},
                double{bench.gpu.texel_of(volume.sample(glm::dvec3(places[i])))}, 1e-4);
    }
}

TEST_F(VolumeFrameTest, UnitCoordinatesRunOverTheBox) {
    Volume volume = test::float_volume({10, 20, 5}, [](glm::uvec3 v) { return v.x / 9.0; });
    volume.spacing_mm = {1, 2, 3};
    const double c = std::cos(0.3), s = std::sin(0.3);
    volume.direction = {{c, s, 0}, {-s, c, 0}, {0, 0, -1}};
    const VolumePlace place = place_of(volume);
    const shader::VolumeFrame frame = frame_of(volume, {});
    for (const glm::vec3 unit : {glm::vec3(0), glm::vec3(1), glm::vec3(0.2f, 0.9f, 0.4f)}) {
        const glm::vec3 world = place.corner + place.edges * glm::dvec3(unit);
        for (int axis = 0; axis < 3; ++axis) {
            EXPECT_NEAR(
                glm::dot(frame.unit_from_world[axis], glm::vec4(world, 1)), unit[axis], 1e-6f);
            EXPECT_NEAR((frame.corner + frame.world_from_unit * unit)[axis], world[axis], 1e-6f);
        }
    }
    EXPECT_EQ(frame.dims, glm::uvec3(10, 20, 5));
    EXPECT_EQ(frame.cells, glm::uvec3(2, 3, 1));
}

TEST_F(VolumeFrameTest, TheDefaultCameraSeesTheWholeBoxWithZUp) {
    const Volume volume = test::float_volume({4, 4, 4}, [](glm::uvec3) { return 1; });
    const shader::VolumeFrame frame = frame_of(volume, {});
    for (int corner = 0; corner < 8; ++corner) {
        const glm::vec3 world =
            glm::vec3(corner & 1, corner >> 1 & 1, corner >> 2 & 1) - glm::vec3(0.5f);
        const glm::vec3 from_camera = world - frame.position;
        const float depth = glm::dot(from_camera, frame.forward);
        const float x =
            glm::dot(from_camera, frame.right) / glm::dot(frame.right, frame.right) / depth;
        const float y = glm::dot(from_camera, frame.up) / glm::dot(frame.up, frame.up) / depth;
        EXPECT_GT(depth, 0.0f);
        EXPECT_LT(std::max(std::abs(x), std::abs(y)), 1.0f);
        EXPECT_EQ(y > 0, world.z > 0);
    }
}

TEST_F(VolumeFrameTest, ValuesAreInTexelUnits) {
    Volume volume = noise({4, 4, 4}, VoxelType::int16); // value = voxel * 2 + 10
    const VolumeGpu gpu(device(), volume, test::linear_transfer());
    EXPECT_FLOAT_EQ(gpu.texel_of(10), 32768.0f / 65535);
    EXPECT_FLOAT_EQ(gpu.texel_of(2 * 1000 + 10), 33768.0f / 65535);
    VolumeView view;
    view.surfaces = {{.value = 2010}, {.value = 10, .opacity = 0.5f}};
    view.density_scale = 40;
    view.clip_planes = {{0, 0, 2, 1}};
    view.light_direction = {0, 3, 0};
    const ValueRange range = value_range(volume);
    const VolumeGpu ramp(device(), volume, ramp_over(volume));
    const shader::VolumeFrame frame =
        make_volume_frame(place_of(volume), ramp, volume_camera(), 64, 64, view);
    EXPECT_EQ(frame.surface_count, 2u);
    // Voxels of just the isovalue are inside.
    EXPECT_LT(frame.surfaces[0].value, gpu.texel_of(2010));
    EXPECT_NEAR(frame.surfaces[0].value, gpu.texel_of(2010), 5e-7f);
    EXPECT_EQ(frame.surfaces[1].opacity, 0.5f);
    EXPECT_EQ(frame.clip_planes[0], glm::vec4(0, 0, 1, 0.5f));
    EXPECT_EQ(frame.light_direction, glm::vec3(0, 1, 0));
    EXPECT_NEAR(frame.majorant, 40.0f, 1e-4f);
    // The function ends where the volume does, and so does the table.
    EXPECT_FLOAT_EQ(frame.table_first, gpu.texel_of(range.lowest));
    EXPECT_NEAR((gpu.texel_of(range.highest) - frame.table_first) * frame.table_scale,
        static_cast<float>(frame.table_size - 1), 1e-3f);
}

TEST_F(VolumeFrameTest, RefusesWhatKernelsCannotHold) {
    const Volume volume = test::float_volume({2, 2, 2}, [](glm::uvec3) { return 1; });
    const auto error = [&](const VolumeView& view) {
        return test::error_of([&] { frame_of(volume, view); });
    };
    VolumeView view;
    view.surfaces.resize(5);
    EXPECT_EQ(error(view), "the view has 5 isovalues; at most 4 are shown at once");
    view = {};
    view.clip_planes.resize(5, {1, 0, 0, 0});
    EXPECT_EQ(error(view), "the view has 5 clip planes; at most 4 are kept beside the crop box");
    view = {};
    view.clip_planes = {{0, 0, 0, 1}};
    EXPECT_EQ(error(view), "clip plane (0, 0, 0, 1): its normal has no length");
    view = {};
    view.crop_max.y = 0;
    EXPECT_EQ(error(view), "the crop box is empty along axis y: 0 to 0");
    view = {};
    view.phase_g = 1;
    EXPECT_EQ(error(view), "the phase function's g is 1; expected a number in (-1, 1)");
    view = {};
    view.albedo = 1.5f;
    EXPECT_EQ(error(view), "the albedo is 1.5; expected a number in [0, 1]");
    view = {};
    view.density_scale = -1;
    EXPECT_EQ(error(view), "the density scale is -1; expected a number in [0, infinity)");
    view = {};
    view.light_direction = glm::vec3(0);
    EXPECT_EQ(error(view),
        "the length of the light's direction is 0; expected a number in (0, infinity)");
}

} // namespace
} // namespace ockham

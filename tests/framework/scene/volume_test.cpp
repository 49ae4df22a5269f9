// SPDX-License-Identifier: Apache-2.0
#include "framework/core/error.hpp"
#include "framework/core/rng.hpp"
#include "framework/scene/volume.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

namespace ockham {
namespace {

template <class T>
Volume volume_of(glm::uvec3 dims, VoxelType type, const std::vector<T>& values) {
    Volume volume;
    volume.name = "test.nrrd";
    volume.dims = dims;
    volume.type = type;
    volume.voxels.resize(values.size() * sizeof(T));
    std::memcpy(volume.voxels.data(), values.data(), volume.voxels.size());
    return volume;
}

std::string refusal(const Volume& volume) {
    try {
        validate(volume);
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::input);
        return error.what();
    }
    return "valid";
}

TEST(VolumeTest, GivesVoxelsOfEveryTypeInDataUnits) {
    const glm::uvec3 dims(2, 1, 2);
    Volume volume = volume_of<std::uint8_t>(dims, VoxelType::uint8, {0, 200, 3, 255});
    EXPECT_EQ(volume.at({1, 0, 0}), 200);
    EXPECT_EQ(volume.at({0, 0, 1}), 3);
    volume = volume_of<std::uint16_t>(dims, VoxelType::uint16, {0, 65535, 3, 40000});
    EXPECT_EQ(volume.at({1, 0, 0}), 65535);
    volume = volume_of<std::int16_t>(dims, VoxelType::int16, {-32768, -1, 3, 32767});
    EXPECT_EQ(volume.at({0, 0, 0}), -32768);
    EXPECT_EQ(volume.at({1, 0, 0}), -1);
    volume = volume_of<float>(dims, VoxelType::float32, {0.25f, -1.5f, 3e20f, 4});
    EXPECT_EQ(volume.at({1, 0, 0}), -1.5);
    volume.value_scale = 2, volume.value_offset = -10;
    EXPECT_EQ(volume.at({0, 0, 0}), -9.5);
    EXPECT_EQ(volume.at({1, 0, 1}), -2);
}

TEST(VolumeTest, ClampsCoordinatesToTheGrid) {
    const Volume volume = volume_of<std::uint8_t>({2, 1, 2}, VoxelType::uint8, {1, 2, 3, 4});
    EXPECT_EQ(volume.at({-5, -1, -1}), 1);
    EXPECT_EQ(volume.at({7, 3, 0}), 2);
    EXPECT_EQ(volume.at({0, 0, 9}), 3);
}

TEST(VolumeTest, SamplesBetweenVoxelCentres) {
    const Volume volume =
        volume_of<float>({2, 2, 2}, VoxelType::float32, {0, 8, 16, 24, 100, 108, 116, 132});
    EXPECT_EQ(volume.sample({0.25, 0.25, 0.25}), 0); // the first voxel's centre
    EXPECT_EQ(volume.sample({0.75, 0.75, 0.75}), 132);
    EXPECT_EQ(volume.sample({0.5, 0.25, 0.25}), 4);
    EXPECT_EQ(volume.sample({0.25, 0.375, 0.25}), 4);
    EXPECT_EQ(volume.sample({0.5, 0.5, 0.5}), (0 + 8 + 16 + 24 + 100 + 108 + 116 + 132) / 8.0);
    // (3/4, 1/4, 1/2) between the centres: rows 6, 22 in front, 106, 128 behind.
    EXPECT_EQ(volume.sample({0.625, 0.375, 0.5}),
        0.5 * (0.75 * 6 + 0.25 * 22) + 0.5 * (0.75 * 106 + 0.25 * 128));
}

TEST(VolumeTest, SamplesTheOutermostCentresBeyondThem) {
    const Volume volume = volume_of<std::uint8_t>({4, 1, 1}, VoxelType::uint8, {10, 20, 30, 50});
    EXPECT_EQ(volume.sample({0.0, 0.5, 0.5}), 10);
    EXPECT_EQ(volume.sample({0.125, 0.0, 1.0}), 10);
    EXPECT_EQ(volume.sample({-3.0, 0.5, 0.5}), 10);
    EXPECT_EQ(volume.sample({1.0, 0.5, 0.5}), 50);
    EXPECT_EQ(volume.sample({1e30, -1e30, 0.5}), 50);
    EXPECT_EQ(volume.sample({0.75, 0.5, 0.5}), 40);
}

TEST(VolumeTest, SamplesALinearFieldExactly) {
    std::vector<float> values;
    for (int z = 0; z < 5; ++z)
        for (int y = 0; y < 4; ++y)
            for (int x = 0; x < 3; ++x) values.push_back(float(2 * x + 32 * y - 8 * z));
    const Volume volume = volume_of({3, 4, 5}, VoxelType::float32, values);
    Pcg32 random(7);
    for (int i = 0; i < 200; ++i) {
        const glm::dvec3 voxel(random.uniform(0, 2), random.uniform(0, 3), random.uniform(0, 4));
        EXPECT_NEAR(volume.sample((voxel + 0.5) / glm::dvec3(3, 4, 5)),
            2 * voxel.x + 32 * voxel.y - 8 * voxel.z, 1e-12);
    }
}

TEST(VolumeTest, FindsTheRangeOfValues) {
    Volume volume = volume_of<std::int16_t>({3, 1, 1}, VoxelType::int16, {-1000, 3000, 7});
    volume.value_scale = 0.5, volume.value_offset = 100;
    EXPECT_EQ(value_range(volume).lowest, -400);
    EXPECT_EQ(value_range(volume).highest, 1600);
}

TEST(VolumeTest, PlacesTheLongestSideAcrossTheOrigin) {
    Volume volume =
        volume_of<std::uint8_t>({4, 2, 1}, VoxelType::uint8, std::vector<std::uint8_t>(8));
    volume.spacing_mm = {1, 1, 8}; // 4 x 2 x 8 mm
    const VolumePlace place = place_of(volume);
    EXPECT_EQ(place.world_per_mm, 0.125);
    EXPECT_EQ(place.corner, glm::dvec3(-0.25, -0.125, -0.5));
    EXPECT_EQ(place.edges[0], glm::dvec3(0.5, 0, 0));
    EXPECT_EQ(place.edges[1], glm::dvec3(0, 0.25, 0));
    EXPECT_EQ(place.edges[2], glm::dvec3(0, 0, 1));
    EXPECT_EQ(place.corner + place.edges * glm::dvec3(0.5), glm::dvec3(0));
}

TEST(VolumeTest, PlacesTheEdgesAlongTheDataAxes) {
    Volume volume =
        volume_of<std::uint8_t>({2, 2, 4}, VoxelType::uint8, std::vector<std::uint8_t>(16));
    volume.direction = {{0, 1, 0}, {0, 0, -1}, {0.6, 0, 0.8}};
    volume.origin_mm = {100, 200, 300};
    const VolumePlace place = place_of(volume);
    EXPECT_EQ(place.edges[0], glm::dvec3(0, 0.5, 0));
    EXPECT_EQ(place.edges[1], glm::dvec3(0, 0, -0.5));
    EXPECT_EQ(place.edges[2], glm::dvec3(0.6, 0, 0.8));
    EXPECT_EQ(place.corner + place.edges * glm::dvec3(0.5), glm::dvec3(0));
}

TEST(VolumeTest, IsPlacedAlikeHoweverItIsSampled) {
    Volume fine = volume_of<std::uint8_t>(
        {64, 64, 64}, VoxelType::uint8, std::vector<std::uint8_t>(64 * 64 * 64));
    Volume flat = volume_of<std::uint8_t>(
        {64, 64, 16}, VoxelType::uint8, std::vector<std::uint8_t>(64 * 64 * 16));
    flat.spacing_mm.z = 4;
    EXPECT_EQ(place_of(fine).corner, place_of(flat).corner);
    EXPECT_EQ(place_of(fine).edges, place_of(flat).edges);
}

TEST(VolumeTest, AcceptsWhatIsUsable) {
    EXPECT_EQ(refusal(volume_of<std::uint8_t>({2, 1, 1}, VoxelType::uint8, {1, 2})), "valid");
    EXPECT_EQ(refusal(volume_of<float>({1, 1, 1}, VoxelType::float32, {-0.0f})), "valid");
    Volume mirrored = volume_of<std::uint8_t>({2, 1, 1}, VoxelType::uint8, {1, 2});
    mirrored.direction[0] = {-1, 0, 0};
    EXPECT_EQ(refusal(mirrored), "valid");
}

TEST(VolumeTest, RefusesWhatIsNot) {
    const Volume good =
        volume_of<float>({2, 2, 3}, VoxelType::float32, std::vector<float>(12, 1.0f));
    const auto changed = [&good](auto&& change) {
        Volume volume = good;
        change(volume);
        return refusal(volume);
    };
    EXPECT_EQ(changed([](Volume& v) { v.dims.y = 0; }),
        "volume 'test.nrrd': 2 x 0 x 3 voxels, expected 1 to 65536 along each axis");
    EXPECT_EQ(changed([](Volume& v) { v.dims.x = 70000; }),
        "volume 'test.nrrd': 70000 x 2 x 3 voxels, expected 1 to 65536 along each axis");
    EXPECT_EQ(changed([](Volume& v) { v.voxels.pop_back(); }),
        "volume 'test.nrrd': 47 bytes of voxels, but 2 x 2 x 3 of float32 are 48");
    EXPECT_EQ(changed([](Volume& v) { v.spacing_mm.z = -1.5; }),
        "volume 'test.nrrd': spacing 1 x 1 x -1.5 mm, expected lengths above 0");
    EXPECT_EQ(changed([](Volume& v) { v.spacing_mm.x = NAN; }),
        "volume 'test.nrrd': spacing nan x 1 x 1 mm, expected lengths above 0");
    EXPECT_EQ(changed([](Volume& v) { v.origin_mm.y = INFINITY; }),
        "volume 'test.nrrd': the origin is not finite");
    EXPECT_EQ(changed([](Volume& v) {
        v.direction[1] = {0, 2, 0};
    }),
        "volume 'test.nrrd': direction of axis 1 is (0, 2, 0), expected a unit vector");
    EXPECT_EQ(changed([](Volume& v) {
        v.direction[1] = {1, 0, 0};
    }),
        "volume 'test.nrrd': the directions of its axes lie in a plane");
    EXPECT_EQ(changed([](Volume& v) { v.value_scale = -2; }),
        "volume 'test.nrrd': values are voxel * -2 + 0, expected a finite scale above 0 and a "
        "finite offset");
    EXPECT_EQ(changed([](Volume& v) { v.value_offset = NAN; }),
        "volume 'test.nrrd': values are voxel * 1 + nan, expected a finite scale above 0 and a "
        "finite offset");
}

TEST(VolumeTest, NamesTheFirstVoxelThatIsNotFinite) {
    std::vector<float> values(24, 0.5f);
    values[4 * 3 + 2 * 1 + 1] = std::numeric_limits<float>::infinity();
    values[23] = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(refusal(volume_of({2, 2, 6}, VoxelType::float32, values)),
        "volume 'test.nrrd': voxel (1, 1, 3) is inf, expected a finite number");
}

} // namespace
} // namespace ockham

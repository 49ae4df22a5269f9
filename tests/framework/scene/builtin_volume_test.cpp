// SPDX-License-Identifier: Apache-2.0
#include "framework/core/error.hpp"
#include "framework/scene/builtin_volume.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

namespace ockham {
namespace {

/// FNV-1a of the voxels.
std::uint64_t hash_of(const Volume& volume) {
    std::uint64_t value = 0xcbf29ce484222325ull;
    for (const std::byte byte : volume.voxels)
        value = (value ^ std::to_integer<std::uint64_t>(byte)) * 0x100000001b3ull;
    return value;
}

double share_of_zeros(const Volume& volume) {
    return double(std::count(volume.voxels.begin(), volume.voxels.end(), std::byte{0})) /
           double(volume.voxel_count());
}

TEST(BuiltinVolumeTest, IsValid) {
    for (const char* name : {"builtin:cloud", "builtin:fingers", "builtin:cluster",
             "builtin:shells", "builtin:slab", "builtin:constant"})
        for (const std::uint32_t side : {1u, 2u, 7u, 65u}) {
            const Volume volume = builtin_volume(name, side);
            EXPECT_NO_THROW(validate(volume)) << name << ' ' << side;
            EXPECT_EQ(volume.name, name);
            EXPECT_EQ(volume.dims.x, side);
        }
}

TEST(BuiltinVolumeTest, IsTheSameOnEveryMachine) {
    EXPECT_EQ(hash_of(builtin_volume("builtin:cloud", 48)), 2565200929695993443ull);
    EXPECT_EQ(hash_of(builtin_volume("builtin:shells", 48)), 11965771227480636525ull);
    EXPECT_EQ(hash_of(builtin_volume("builtin:fingers", 48)), 15895159351118345271ull);
    EXPECT_EQ(hash_of(builtin_volume("builtin:cluster", 48)), 18190124379223950177ull);
}

TEST(BuiltinVolumeTest, CloudIsEmptyAround) {
    const Volume volume = builtin_volume("builtin:cloud");
    EXPECT_EQ(volume.dims, glm::uvec3(128, 128, 96));
    EXPECT_GT(share_of_zeros(volume), 0.75);
    EXPECT_LT(share_of_zeros(volume), 0.9);
    const glm::ivec3 last = glm::ivec3(volume.dims) - 1;
    for (int axis = 0; axis < 3; ++axis)
        for (int i = 0; i < 128 * 128; ++i) {
            glm::ivec3 voxel(i % 128);
            voxel[(axis + 1) % 3] = i / 128;
            voxel[axis] = 0;
            ASSERT_EQ(volume.at(voxel), 0) << axis << ' ' << i;
            voxel[axis] = last[axis];
            ASSERT_EQ(volume.at(voxel), 0) << axis << ' ' << i;
        }
}

/// Most of the cloud is dense, most of its height is above the widest row, and its underside flat.
TEST(BuiltinVolumeTest, CloudIsACumulus) {
    const Volume volume = builtin_volume("builtin:cloud", 64);
    std::vector<int> filled(volume.dims.z); // voxels of a layer
    for (int z = 0; z < int(volume.dims.z); ++z)
        for (int y = 0; y < 64; ++y)
            for (int x = 0; x < 64; ++x) filled[std::size_t(z)] += volume.at({x, y, z}) > 64;
    const auto widest = std::max_element(filled.begin(), filled.end());
    const auto lowest = std::find_if(filled.begin(), filled.end(), [](int n) { return n > 0; });
    const auto highest = std::find_if(filled.rbegin(), filled.rend(), [](int n) { return n > 0; });
    const auto height = highest.base() - lowest;
    EXPECT_GT(height, 28);
    EXPECT_LT(widest - lowest, height / 3);
    EXPECT_GT(*(lowest + 2), *widest / 2);
}

TEST(BuiltinVolumeTest, ShellsAreOneToEightVoxelsThick) {
    const Volume volume = builtin_volume("builtin:shells", 128);
    // Along the row through the centre, from outside: thickness at half of the value, and gaps.
    double level = 0, entered = 0;
    std::vector<double> thickness;
    for (double x = 0.5; x < 64; x += 1.0 / 64) {
        const double value = volume.sample({x / 128, 0.5, 0.5});
        if (level < 127.5 && value >= 127.5) entered = x;
        if (level >= 127.5 && value < 127.5) thickness.push_back(x - entered);
        level = value;
    }
    ASSERT_EQ(thickness.size(), 8u);
    for (std::size_t i = 0; i < 8; ++i) EXPECT_NEAR(thickness[i], double(i + 1), 0.15) << i;
}

/// The field along the middle of the outermost shell.
TEST(BuiltinVolumeTest, TheThinnestShellHasNoHoles) {
    for (const std::uint32_t side : {16u, 33u, 64u, 128u}) {
        const Volume volume = builtin_volume("builtin:shells", side);
        const double radius = 0.5 * side - 2 - 0.5;
        double least = 255;
        for (int i = 0; i < 50000; ++i) { // a spiral of equal areas
            const double z = 1 - (i + 0.5) / 25000.0;
            const double angle = i * 2.399963229728653;
            const double r = std::sqrt(1 - z * z);
            const glm::dvec3 way(r * std::cos(angle), r * std::sin(angle), z);
            least = std::min(least, volume.sample(0.5 + way * (radius / side)));
        }
        EXPECT_GT(least, 100) << side;
    }
}

TEST(BuiltinVolumeTest, ShellsLeaveOutWhatDoesNotFit) {
    const Volume volume = builtin_volume("builtin:shells", 32);
    EXPECT_EQ(volume.sample({0.5, 0.5, 0.5}), 0);
    EXPECT_GT(share_of_zeros(volume), 0.5);
    EXPECT_EQ(*std::max_element(volume.voxels.begin(), volume.voxels.end()), std::byte{255});
}

TEST(BuiltinVolumeTest, SlabAndConstantAreOne) {
    for (const std::uint32_t side : {16u, 64u, 128u, 200u}) {
        const Volume slab = builtin_volume("builtin:slab", side);
        EXPECT_EQ(place_of(slab).edges, glm::dmat3({1, 0, 0}, {0, 1, 0}, {0, 0, 1.0 / 64}));
        EXPECT_EQ(value_range(slab).lowest, 1);
        EXPECT_EQ(value_range(slab).highest, 1);
    }
    const Volume constant = builtin_volume("builtin:constant", 8);
    EXPECT_EQ(constant.dims, glm::uvec3(8));
    EXPECT_EQ(value_range(constant).lowest, 1);
    EXPECT_EQ(value_range(constant).highest, 1);
}

/// Lengths of the runs of voxels above `value` along x in one row.
std::vector<int> runs_above(const Volume& volume, double value, int y, int z) {
    std::vector<int> runs;
    bool inside = false;
    for (int x = 0; x < int(volume.dims.x); ++x) {
        const bool above = volume.at({x, y, z}) > value;
        if (above && !inside) runs.push_back(0);
        if (above) ++runs.back();
        inside = above;
    }
    return runs;
}

TEST(BuiltinVolumeTest, FingersAreThinAndStandFreeBeforeTissue) {
    const Volume volume = builtin_volume("builtin:fingers");
    // Halfway up, each rod shows once, as a spot 2 to 4 voxels wide, somewhere before the tissue.
    const int z = 60;
    std::vector<int> widest(128, 0); // along x, of what is seen from the front
    int front = 128;                 // of the tissue
    for (int y = 0; y < 128; ++y)
        for (int x = 0; x < 128; ++x) {
            const double value = volume.at({x, y, z});
            if (value > 180) widest[x] = 1;
            if (value > 60 && value < 180 && x == 64 && y > 50) front = std::min(front, y);
        }
    int rods = 0, width = 0;
    for (int x = 0; x < 128; ++x) {
        width = widest[x] > 0 ? width + 1 : 0;
        if (width == 1) ++rods;
        EXPECT_LE(width, 4) << x;
    }
    EXPECT_EQ(rods, 5);
    // The middle rod is four times as far from the tissue as it is thick.
    for (int y = front - 12; y < front; ++y) EXPECT_LT(volume.at({64, y, z}), 60) << y;
}

TEST(BuiltinVolumeTest, ClusterIsManySpotsOfFewVoxels) {
    const Volume volume = builtin_volume("builtin:cluster");
    int spots = 0, wide = 0;
    for (int z = 0; z < 128; ++z)
        for (int y = 0; y < 128; ++y)
            for (const int run : runs_above(volume, 100, y, z)) {
                ++spots;
                wide += run > 3 ? 1 : 0;
            }
    EXPECT_GT(spots, 3000);
    EXPECT_LT(wide, spots / 50);
    std::size_t haze = 0;
    for (const std::byte voxel : volume.voxels)
        haze += voxel > std::byte{0} && voxel < std::byte{11};
    EXPECT_GT(haze, volume.voxel_count() / 8);
}

TEST(BuiltinVolumeTest, RefusesOtherNamesAndSides) {
    const auto refusal = [](const std::string& name, std::uint32_t side) -> std::string {
        try {
            builtin_volume(name, side);
        } catch (const Error& error) {
            return error.what();
        }
        return "made";
    };
    EXPECT_EQ(refusal("builtin:fog", 8),
        "no volume 'builtin:fog': there are builtin:cloud, "
        "builtin:fingers, builtin:cluster, builtin:shells, builtin:slab, builtin:constant");
    EXPECT_EQ(
        refusal("builtin:cloud", 0), "volume 'builtin:cloud': 0 voxels a side, expected 1 to 1024");
    EXPECT_EQ(refusal("builtin:cloud", 1025),
        "volume 'builtin:cloud': 1025 voxels a side, expected 1 to 1024");
}

TEST(Sky, ItsSunIrradiatesByAboutPi) {
    const Image sky = sky_with_sun();
    double irradiance = 0;
    for (int y = 0; y < sky.height(); ++y)
        for (int x = 0; x < sky.width(); ++x)
            if (sky.at(x, y, 0) > 100)
                irradiance += sky.at(x, y, 0) * std::sin(std::numbers::pi * (y + 0.5) / 64) *
                              (std::numbers::pi / 64) * (2 * std::numbers::pi / 128);
    EXPECT_NEAR(irradiance, std::numbers::pi, 0.4);
}

} // namespace
} // namespace ockham

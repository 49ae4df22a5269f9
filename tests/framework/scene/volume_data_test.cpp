// SPDX-License-Identifier: Apache-2.0
// What default transfer functions make of real volumes: the empty space must stay empty. Runs where
// OCKHAM_DATA_DIR is set; histogram_test and transfer_function_test have generated equivalents.
#include "framework/io/volume_file.hpp"
#include "framework/scene/transfer_function.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace ockham {
namespace {

struct EmptyShares {
    double voxels = 0, bricks = 0; ///< of opacity 0; bricks of 8^3 voxels wholly so
};

EmptyShares empty_shares(const std::string& name) {
    const Volume volume = load_volume(std::string(OCKHAM_DATA_DIR) + "/volumes/" + name + ".json");
    const TransferFunction function = default_transfer(volume);
    const glm::ivec3 bricks = (glm::ivec3(volume.dims) + 7) / 8;
    std::vector<char> filled(std::size_t(bricks.x) * bricks.y * bricks.z, 0);
    std::size_t empty = 0;
    glm::ivec3 p;
    for (p.z = 0; p.z < int(volume.dims.z); ++p.z)
        for (p.y = 0; p.y < int(volume.dims.y); ++p.y)
            for (p.x = 0; p.x < int(volume.dims.x); ++p.x) {
                const glm::ivec3 b = p / 8;
                if (function.at(volume.at(p)).opacity == 0)
                    ++empty;
                else
                    filled[std::size_t((b.z * bricks.y + b.y) * bricks.x + b.x)] = 1;
            }
    return {double(empty) / double(volume.voxel_count()),
        double(std::count(filled.begin(), filled.end(), 0)) / double(filled.size())};
}

// The shares of an engine block and a head at thresholds set by hand: 0.86 and 0.74, 0.67 and 0.55.
TEST(VolumeDataTest, AnEngineIsMostlyEmpty) {
    const EmptyShares empty = empty_shares("engine");
    EXPECT_NEAR(empty.voxels, 0.86, 0.01);
    EXPECT_NEAR(empty.bricks, 0.74, 0.01);
}

TEST(VolumeDataTest, TheAirAroundAHeadIsEmpty) {
    const EmptyShares empty = empty_shares("cranium_ct");
    EXPECT_NEAR(empty.voxels, 0.67, 0.01);
    EXPECT_NEAR(empty.bricks, 0.55, 0.03);
}

// 31 % of the smoke's voxels are above 0, most of them hardly.
TEST(VolumeDataTest, TheAirAroundSmokeIsEmpty) {
    const EmptyShares empty = empty_shares("smoke_density");
    EXPECT_GT(empty.voxels, 0.69);
    EXPECT_LT(empty.voxels, 0.97);
    EXPECT_GT(empty.bricks, 0.55);
}

} // namespace
} // namespace ockham

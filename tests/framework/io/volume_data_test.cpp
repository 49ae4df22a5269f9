// SPDX-License-Identifier: Apache-2.0
// Real volumes. Registered only where OCKHAM_DATA_DIR is set; volume_file_test has generated ones.
#include "framework/core/file.hpp"
#include "tests/support/volume_file_test.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ockham {
namespace {

namespace fs = std::filesystem;

const fs::path kVolumes = fs::path(OCKHAM_DATA_DIR) / "volumes";

class VolumeData : public test::VolumeFileTest {};

TEST_F(VolumeData, EachLoadsWithTheRangeThatItStates) {
    int loaded = 0;
    for (const auto& entry : fs::directory_iterator(kVolumes)) {
        if (entry.path().extension() != ".json") continue;
        SCOPED_TRACE(entry.path().filename().string());
        const auto sidecar = nlohmann::json::parse(read_text(entry.path()));
        const Volume volume = load_volume(entry.path().string());
        ++loaded;
        for (int axis = 0; axis < 3; ++axis) {
            EXPECT_EQ(
                volume.spacing_mm[axis], sidecar["spacing_mm"][static_cast<std::size_t>(axis)]);
        }
        if (!sidecar.contains("min")) continue;
        double low = std::numeric_limits<double>::max(), high = -low, sum = 0;
        const glm::ivec3 dims(volume.dims);
        for (int z = 0; z < dims.z; ++z)
            for (int y = 0; y < dims.y; ++y)
                for (int x = 0; x < dims.x; ++x) {
                    const double value = volume.at({x, y, z});
                    low = std::min(low, value);
                    high = std::max(high, value);
                    sum += value;
                }
        EXPECT_EQ(low, sidecar["min"].get<double>());
        EXPECT_EQ(high, sidecar["max"].get<double>());
        const double mean = sidecar["mean"];
        EXPECT_NEAR(sum / static_cast<double>(volume.voxel_count()), mean, 1e-5 * std::abs(mean));
    }
    EXPECT_GE(loaded, 10);
}

/// The same field twice: the .vdb keeps what is not zero, and where it lies.
TEST_F(VolumeData, SparseAndRawAgree) {
    if (!OCKHAM_WITH_OPENVDB) return;
    const Volume raw = load_volume((kVolumes / "bump64.json").string());
    const Volume sparse = load_volume((kVolumes / "bump64.vdb").string());
    // The box of the raw one is the unit cube around the origin of the .vdb's world.
    EXPECT_NEAR(sparse.spacing_mm.x, 1.0 / 64, 1e-12);
    const glm::ivec3 first(glm::round((sparse.origin_mm + 0.5) * 64.0 - 0.5));
    EXPECT_EQ(first, glm::ivec3(2));
    const glm::ivec3 dims(raw.dims), kept(sparse.dims);
    for (int z = 0; z < dims.z; ++z)
        for (int y = 0; y < dims.y; ++y)
            for (int x = 0; x < dims.x; ++x) {
                const glm::ivec3 there = glm::ivec3(x, y, z) - first;
                const bool inside = glm::clamp(there, glm::ivec3(0), kept - 1) == there;
                ASSERT_EQ(raw.at({x, y, z}), inside ? sparse.at(there) : 0.0)
                    << x << ' ' << y << ' ' << z;
            }
}

} // namespace
} // namespace ockham

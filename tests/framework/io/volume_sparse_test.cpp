// SPDX-License-Identifier: Apache-2.0
// Grids of .vdb and .nvdb files, written by their libraries. Registered where both were found.
#include "tests/support/volume_file_test.hpp"

#include <nanovdb/util/GridBuilder.h>
#include <nanovdb/util/IO.h>
#include <openvdb/openvdb.h>

#include <limits>

namespace ockham {
namespace {

/// Active: indices (-2, 3, 5) to (1, 5, 6); the value there is x + 10 y + 100 z, and 2 outside.
constexpr glm::ivec3 kFirst(-2, 3, 5), kLast(1, 5, 6);
constexpr float kOutside = 2;

float value_at(int x, int y, int z) { return static_cast<float>(x + 10 * y + 100 * z); }

template <class Set>
void fill(Set set) {
    for (int z = kFirst.z; z <= kLast.z; ++z)
        for (int y = kFirst.y; y <= kLast.y; ++y)
            for (int x = kFirst.x; x <= kLast.x; ++x) set(x, y, z, value_at(x, y, z));
}

/// The active voxels and a border of one.
void expect_grid(const Volume& volume) {
    ASSERT_EQ(volume.dims, glm::uvec3(kLast - kFirst + 3));
    EXPECT_EQ(volume.type, VoxelType::float32);
    for (int z = 0; z < static_cast<int>(volume.dims.z); ++z)
        for (int y = 0; y < static_cast<int>(volume.dims.y); ++y)
            for (int x = 0; x < static_cast<int>(volume.dims.x); ++x) {
                const glm::ivec3 index = kFirst + glm::ivec3(x - 1, y - 1, z - 1);
                const bool active = glm::clamp(index, kFirst, kLast) == index;
                EXPECT_EQ(
                    volume.at({x, y, z}), active ? value_at(index.x, index.y, index.z) : kOutside)
                    << x << ' ' << y << ' ' << z;
            }
    ASSERT_FALSE(volume.notes.empty());
    EXPECT_EQ(volume.notes.back(),
        "a sparse grid made dense: 6 x 5 x 4 voxels, which are its active ones, from index (-2, 3, "
        "5), and a border of one voxel (outside of them it is 2)");
}

class VolumeVdb : public test::VolumeFileTest {
protected:
    VolumeVdb() { openvdb::initialize(); }

    static openvdb::FloatGrid::Ptr grid(const std::string& name) {
        auto grid = openvdb::FloatGrid::create(kOutside);
        grid->setName(name);
        auto accessor = grid->getAccessor();
        fill([&](int x, int y, int z, float value) { accessor.setValue({x, y, z}, value); });
        return grid;
    }
    void write(const std::string& name, const openvdb::GridPtrVec& grids) {
        openvdb::io::File(file(name).string()).write(grids);
    }
};

TEST_F(VolumeVdb, ActiveVoxelsAndABorder) {
    const auto stored = grid("density");
    // Columns: twice along world y, thrice along -x, half along z; then a translation.
    const double columns[16] = {0, 2, 0, 0, -3, 0, 0, 0, 0, 0, 0.5, 0, 10, 20, 30, 1};
    stored->setTransform(openvdb::math::Transform::createLinearTransform(openvdb::Mat4d(columns)));
    write("a.vdb", {stored});
    const Volume volume = load("a.vdb");
    expect_grid(volume);
    EXPECT_EQ(volume.spacing_mm, glm::dvec3(2, 3, 0.5));
    EXPECT_EQ(volume.direction[0], glm::dvec3(0, 1, 0));
    EXPECT_EQ(volume.direction[1], glm::dvec3(-1, 0, 0));
    EXPECT_EQ(volume.direction[2], glm::dvec3(0, 0, 1));
    // The centre of voxel (-3, 2, 4), where the transform puts that index.
    EXPECT_EQ(volume.origin_mm, glm::dvec3(10 - 6, 20 - 6, 30 + 2));
}

TEST_F(VolumeVdb, DensityUnlessAGridIsNamed) {
    const auto heat = grid("heat");
    heat->tree().setValue({-2, 3, 5}, -7);
    write("a.vdb", {heat, grid("density")});
    Volume volume = load("a.vdb");
    expect_grid(volume);
    ASSERT_EQ(volume.notes.size(), 2u);
    EXPECT_EQ(
        volume.notes[0], "grid 'density' is read; also there: 'heat' (append #NAME to the path)");
    volume = load("a.vdb#heat");
    EXPECT_EQ(volume.at({1, 1, 1}), -7);
    EXPECT_EQ(volume.notes.size(), 1u);
    const std::string text = refusal("a.vdb#cold");
    expect_contains(text, "a.vdb': it has no grid 'cold'; it has ");
    expect_contains(text, "'heat'");
}

TEST_F(VolumeVdb, RefusesWhatIsNoFloatGrid) {
    auto vectors = openvdb::Vec3SGrid::create();
    vectors->setName("velocity");
    vectors->tree().setValue({1, 2, 3}, {1, 0, 0});
    write("a.vdb", {vectors});
    expect_contains(refusal("a.vdb"), "grid 'velocity' has values of type vec3s, expected float; "
                                      "choose another grid or convert it");
    write("a.vdb", {openvdb::FloatGrid::create()});
    expect_contains(refusal("a.vdb"), "a.vdb': its grid has no active voxel");
    write("a.vdb", openvdb::GridPtrVec());
    expect_contains(refusal("a.vdb"), "a.vdb': it has no grid");
    auto far = openvdb::FloatGrid::create();
    far->tree().setValue({-2147483647, 0, 0}, 1);
    far->tree().setValue({2147483646, 0, 0}, 1);
    write("a.vdb", {far});
    expect_contains(refusal("a.vdb"), "it states 4294967296 x 3 x 3 voxels");
    auto frustum = grid("density");
    frustum->setTransform(openvdb::math::Transform::createFrustumTransform(
        openvdb::BBoxd({0, 0, 0}, {9, 9, 9}), 0.5, 2));
    write("a.vdb", {frustum});
    expect_contains(refusal("a.vdb"), "grid 'density' lies in a frustum, expected a regular grid");
    auto infinite = grid("density");
    infinite->tree().setValue({-2, 3, 5}, std::numeric_limits<float>::infinity());
    write("a.vdb", {infinite});
    expect_contains(refusal("a.vdb"), "voxel (1, 1, 1) is inf");
}

TEST_F(VolumeVdb, FilesCutOffAreRefused) {
    write("a.vdb", {grid("density")});
    std::ifstream stream(file("a.vdb"), std::ios::binary);
    const std::string bytes(std::istreambuf_iterator<char>(stream), {});
    for (std::size_t size = 0; size < bytes.size(); size += size < 1500 ? 11 : 1997) {
        scribble("b.vdb", bytes.substr(0, size));
        EXPECT_NE(refusal("b.vdb"), "loaded") << size << " of " << bytes.size();
    }
}

class VolumeNanoVdb : public test::VolumeFileTest {
protected:
    template <class Build = float>
    static nanovdb::GridHandle<> grid(const std::string& name) {
        nanovdb::GridBuilder<float, Build> builder(kOutside);
        auto accessor = builder.getAccessor();
        fill([&](int x, int y, int z, float value) {
            accessor.setValue(nanovdb::Coord(x, y, z), value);
        });
        return builder.template getHandle<>(2.0, nanovdb::Vec3d(10, 20, 30), name);
    }
    std::string bytes_of_file(const std::string& name) {
        std::ifstream stream(file(name), std::ios::binary);
        return {std::istreambuf_iterator<char>(stream), {}};
    }
};

TEST_F(VolumeNanoVdb, ActiveVoxelsAndABorder) {
    nanovdb::io::writeGrid(file("a.nvdb").string(), grid("density"));
    const Volume volume = load("a.nvdb");
    expect_grid(volume);
    EXPECT_EQ(volume.spacing_mm, glm::dvec3(2));
    EXPECT_EQ(volume.direction, glm::dmat3(1));
    EXPECT_EQ(volume.origin_mm, glm::dvec3(10 - 6, 20 + 4, 30 + 8));
}

TEST_F(VolumeNanoVdb, ZippedAlsoOfSeveralGrids) {
    std::vector<nanovdb::GridHandle<>> grids;
    grids.push_back(grid("heat"));
    grids.push_back(grid("density"));
    nanovdb::io::writeGrids(file("a.nvdb").string(), grids, nanovdb::io::Codec::ZIP);
    const Volume volume = load("a.nvdb");
    expect_grid(volume);
    EXPECT_EQ(
        volume.notes[0], "grid 'density' is read; also there: 'heat' (append #NAME to the path)");
    expect_grid(load("a.nvdb#heat"));
    expect_contains(refusal("a.nvdb#cold"), "it has no grid 'cold'; it has 'heat', 'density'");
}

TEST_F(VolumeNanoVdb, QuantisedFloatsAreRead) {
    nanovdb::io::writeGrid(file("a.nvdb").string(), grid<nanovdb::Fp16>("density"));
    const Volume volume = load("a.nvdb");
    EXPECT_EQ(volume.dims, glm::uvec3(6, 5, 4));
    EXPECT_NEAR(volume.at({1, 1, 1}), value_at(-2, 3, 5), 0.02);
}

TEST_F(VolumeNanoVdb, RefusesWhatIsDamaged) {
    nanovdb::io::writeGrid(file("a.nvdb").string(), grid("density"));
    const std::string bytes = bytes_of_file("a.nvdb");
    for (std::size_t size = 1; size < bytes.size(); size += size < 300 ? 7 : 49999) {
        scribble("b.nvdb", bytes.substr(0, size));
        expect_contains(refusal("b.nvdb"), "b.nvdb': it ends too early: ");
    }
    scribble("b.nvdb", "");
    expect_contains(refusal("b.nvdb"), "b.nvdb': it has no grid");
    scribble("b.nvdb", "x" + bytes);
    expect_contains(refusal("b.nvdb"), "expected NanoVDB's 304244566f6e614e");
    std::string damaged = bytes;
    damaged[14] = 2; // the codec
    scribble("b.nvdb", damaged);
    expect_contains(refusal("b.nvdb"), "it is compressed by blosc, expected zip or none");
    damaged = bytes;
    damaged[16 + 6] = 1; // the size of the grid
    scribble("b.nvdb", damaged);
    expect_contains(refusal("b.nvdb"), " are stored; the file is damaged");
    damaged = bytes;
    damaged[16 + 176 + 8 + 600] ^= 0x55; // in the grid itself, after header, description and name
    scribble("b.nvdb", damaged);
    expect_contains(refusal("b.nvdb"), "grid 'density' is damaged: Mis-matching checksum");
}

} // namespace
} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
// load_volume(): the choice of the reader, raw voxels with their JSON file, and what is refused.
// volume_itk_test and volume_sparse_test have the formats of the optional libraries.
#include "tests/support/volume_file_test.hpp"

#include "framework/core/file.hpp"

#include <cmath>
#include <limits>

namespace ockham {
namespace {

class VolumeFile : public test::VolumeFileTest {
protected:
    /// A sidecar "a.json" of 2 x 3 x 4 uint16 voxels with `change` merged into it.
    void write_sidecar(const nlohmann::json& change) {
        nlohmann::json sidecar = {{"file", "a.raw"}, {"dims", {2, 3, 4}}, {"type", "uint16"},
            {"spacing_mm", {0.5, 1, 2.25}}};
        sidecar.merge_patch(change);
        scribble("a.json", sidecar.dump());
    }
    /// What load_volume() says to it.
    std::string refusal_of(const nlohmann::json& change) {
        write_sidecar(change);
        return refusal("a.json");
    }
};

TEST_F(VolumeFile, RawVoxelsAsStated) {
    scribble("a.raw", test::ramp<std::uint16_t>(24, 1000));
    write_sidecar({{"direction", {0, 1, 0, -1, 0, 0, 0, 0, 1}}, {"origin_mm", {10, -20, 0.125}}});
    const Volume volume = load("a.json");
    EXPECT_EQ(volume.name, file("a.json").string());
    EXPECT_EQ(volume.dims, glm::uvec3(2, 3, 4));
    EXPECT_EQ(volume.type, VoxelType::uint16);
    EXPECT_EQ(volume.spacing_mm, glm::dvec3(0.5, 1, 2.25));
    // The first axis of the data is the world's second.
    EXPECT_EQ(volume.direction[0], glm::dvec3(0, 1, 0));
    EXPECT_EQ(volume.direction[1], glm::dvec3(-1, 0, 0));
    EXPECT_EQ(volume.origin_mm, glm::dvec3(10, -20, 0.125));
    EXPECT_EQ(volume.value_scale, 1);
    EXPECT_EQ(volume.value_offset, 0);
    EXPECT_TRUE(volume.notes.empty());
    for (int z = 0; z < 4; ++z)
        for (int y = 0; y < 3; ++y)
            for (int x = 0; x < 2; ++x)
                EXPECT_EQ(volume.at({x, y, z}), 1000 + x + 2 * y + 6 * z); // x fastest
}

TEST_F(VolumeFile, RawVoxelsOfEveryType) {
    scribble("u8.raw", test::ramp<std::uint8_t>(24, 200));
    scribble("i16.raw", test::ramp<std::int16_t>(24, -1024));
    scribble("f32.raw", test::ramp<float>(24, -0.5f));
    const std::tuple<const char*, const char*, VoxelType, double> cases[] = {
        {"u8.raw", "uint8", VoxelType::uint8, 200.0},
        {"i16.raw", "int16", VoxelType::int16, -1024.0},
        {"f32.raw", "float32", VoxelType::float32, -0.5}};
    for (const auto& [name, type, expected, first] : cases) {
        SCOPED_TRACE(type);
        write_sidecar({{"file", name}, {"type", type}});
        const Volume volume = load("a.json");
        EXPECT_EQ(volume.type, expected);
        EXPECT_EQ(volume.at({0, 0, 0}), first);
        EXPECT_EQ(volume.at({1, 2, 3}), first + 23);
    }
}

TEST_F(VolumeFile, GzippedVoxelsAlsoInMembers) {
    const std::string bytes = test::ramp<std::uint16_t>(24, 7);
    scribble("a.raw.gz", test::gzip(bytes));
    write_sidecar({{"file", "a.raw.gz"}});
    EXPECT_EQ(load("a.json").at({1, 2, 3}), 30);
    scribble("a.raw.gz", test::gzip(bytes.substr(0, 20)) + test::gzip(bytes.substr(20)));
    EXPECT_EQ(load("a.json").at({1, 2, 3}), 30);
}

TEST_F(VolumeFile, UnknownKeysAreNoted) {
    scribble("a.raw", test::ramp<std::uint16_t>(24, 0));
    write_sidecar({{"modality", "CT"}, {"min", 0}});
    const Volume volume = load("a.json");
    ASSERT_EQ(volume.notes.size(), 1u);
    EXPECT_EQ(volume.notes[0], "the sidecar's keys 'min', 'modality' are not read");
}

TEST_F(VolumeFile, AxesOffRightAnglesAreNoted) {
    scribble("a.raw", test::ramp<std::uint16_t>(24, 0));
    write_sidecar({{"direction", {1, 0, 0, 0, 1, 0, 0, 0.6, 0.8}}});
    const Volume volume = load("a.json");
    ASSERT_EQ(volume.notes.size(), 1u);
    EXPECT_EQ(
        volume.notes[0], "its axes are 36.87 degrees off right angles, which is not honoured");
}

TEST_F(VolumeFile, SizesThatDisagreeGiveBothNumbersAndTheFormula) {
    scribble("a.raw", std::string(47, 'x'));
    EXPECT_EQ(refusal_of(nlohmann::json::object()),
        "cannot load volume '" + file("a.json").string() +
            "': 'a.raw' has 47 bytes, but 2 x 3 x 4 voxels of uint16 take 2 * 3 * 4 * 2 = 48: "
            "correct dims or type");
    scribble("a.raw", std::string(49, 'x'));
    expect_contains(refusal_of(nlohmann::json::object()), "has 49 bytes, but");
    scribble("a.raw.gz", test::gzip(std::string(47, 'x')));
    expect_contains(refusal_of({{"file", "a.raw.gz"}}), "has 47 bytes unpacked, but 2 x 3 x 4");
    scribble("a.raw.gz", test::gzip(std::string(1000, 'x')));
    expect_contains(refusal_of({{"file", "a.raw.gz"}}), "has more than 48 bytes unpacked, but");
    // Refused before a gibibyte is asked for.
    expect_contains(
        refusal_of({{"file", "a.raw.gz"}, {"dims", {1024, 1024, 512}}}), "bytes of gzip, at most ");
}

TEST_F(VolumeFile, DamagedGzipIsRefused) {
    const std::string packed = test::gzip(test::ramp<std::uint16_t>(24, 7));
    nlohmann::json change = {{"file", "a.raw.gz"}};
    for (std::size_t size = 0; size < packed.size(); ++size) {
        SCOPED_TRACE(size);
        scribble("a.raw.gz", packed.substr(0, size));
        const std::string text = refusal_of(change);
        EXPECT_TRUE(text.find("ends too early") != std::string::npos ||
                    text.find("of gzip, at most") != std::string::npos)
            << text;
    }
    for (std::size_t at = 0; at < packed.size(); ++at) {
        if (at >= 4 && at < 10) continue; // time, level and system: no part of the data
        SCOPED_TRACE(at);
        std::string damaged = packed;
        damaged[at] = static_cast<char>(damaged[at] ^ 0x55);
        scribble("a.raw.gz", damaged);
        EXPECT_NE(refusal_of(change), "loaded");
    }
    scribble("a.raw.gz", packed + "rest");
    expect_contains(refusal_of(change), "its gzip data is damaged (incorrect header check)");
}

TEST_F(VolumeFile, SidecarsThatAreWrong) {
    scribble("a.raw", test::ramp<std::uint16_t>(24, 0));
    const std::pair<nlohmann::json, const char*> cases[] = {
        {{{"dims", nullptr}}, "dims is missing"},
        {{{"spacing_mm", nullptr}}, "spacing_mm is missing"},
        {{{"file", nullptr}}, "file is missing"},
        {{{"dims", {2, 12}}}, "dims is [2,12], expected three whole numbers of at least 1"},
        {{{"dims", {2, 3.5, 4}}}, "dims is [2,3.5,4], expected three whole numbers"},
        {{{"dims", {2, -3, 4}}}, "dims is -3, expected three whole numbers"},
        {{{"dims", {0, 3, 4}}}, "dims is 0, expected three whole numbers of at least 1"},
        {{{"dims", {65536, 65536, 1}}}, "65536 x 65536 x 1 voxels, expected at least 1 along each "
                                        "axis and at most 2147483648 in all; crop or subsample it"},
        {{{"dims", {4294967296, 4294967296, 1}}}, "4294967296 x 4294967296 x 1 voxels"},
        {{{"type", "int8"}}, "type is \"int8\", expected uint8, int16, uint16 or float32"},
        {{{"type", 8}}, "type is 8, expected a string"},
        {{{"spacing_mm", {1, 1, "2"}}}, "spacing_mm is \"2\", expected three numbers"},
        {{{"spacing_mm", {1, 0, 1}}}, "spacing 1 x 0 x 1 mm, expected lengths above 0"},
        {{{"direction", {1, 0, 0}}}, "direction is [1,0,0], expected three unit vectors"},
        {{{"direction", {1, 0, 0, 0, 0.5, 0, 0, 0, 1}}}, "direction of axis 1 is (0, 0.5, 0)"},
        {{{"file", "b.raw"}}, "b.raw': No such file"},
        {{{"file", "../a.raw"}}, "the file '../a.raw' that it names is outside of its folder"},
        {{{"file", "/etc/hostname"}}, "the file '/etc/hostname' that it names is outside"},
        {{{"file", ""}}, "the file '' that it names is outside"},
    };
    for (const auto& [change, text] : cases) expect_contains(refusal_of(change), text);
    scribble("a.json", "{\"file\":");
    expect_contains(refusal("a.json"), "a.json': not valid JSON: ");
    scribble("a.json", "[1]");
    expect_contains(refusal("a.json"), "the volume is [1], expected an object");
}

TEST_F(VolumeFile, ValuesThatAreNoNumbersAreNamed) {
    std::string bytes = test::ramp<float>(24, 0);
    const float bad = std::numeric_limits<float>::quiet_NaN();
    std::memcpy(bytes.data() + 4 * 13, &bad, 4); // 13 = 1 + 2 * 0 + 6 * 2
    scribble("a.raw", bytes);
    expect_contains(refusal_of({{"type", "float32"}}), "voxel (1, 0, 2) is nan");
}

TEST_F(VolumeFile, NamesThatNoReaderKnows) {
    scribble("a.xyz", "x");
    scribble("a.raw", "x");
    scribble("a.json", "{}");
    expect_contains(refusal("a.xyz"), "a.xyz': the end of its name is not known; expected "
                                      "builtin:NAME, .json (raw voxels)");
    expect_contains(refusal("a.raw"), "raw voxels need a .json beside them");
    expect_contains(refusal("missing.nrrd"), "missing.nrrd': No such file or directory");
    expect_contains(refusal("a.json#b"), "its format has no parts to choose, remove '#b'");
}

TEST_F(VolumeFile, BuiltinsAreVolumesToo) {
    EXPECT_EQ(load_volume("builtin:constant").at({0, 0, 0}), 1.0);
    EXPECT_THROW(load_volume("builtin:nothing"), Error);
    EXPECT_EQ(load_volume("builtin:cloud:16").dims, glm::uvec3(16, 16, 12));
    for (const char* name : {"builtin:cloud:", "builtin:cloud:x", "builtin:cloud:16x"})
        EXPECT_THROW(load_volume(name), Error) << name;
}

/// Each optional library is either there, or asked for by its package.
TEST_F(VolumeFile, FormatsThatTheBuildLacksNameTheirPackages) {
    const std::tuple<bool, const char*, const char*> readers[] = {
        {OCKHAM_WITH_ITK, "a.nrrd", "built without ITK, install libinsighttoolkit5-dev"},
        {OCKHAM_WITH_OPENVDB, "a.vdb",
            "built without OpenVDB, install libopenvdb-dev and libboost-dev"},
        {OCKHAM_WITH_NANOVDB, "a.nvdb", "built without NanoVDB, install libnanovdb-dev"}};
    for (const auto& [present, name, lacks] : readers) {
        SCOPED_TRACE(name);
        scribble(name, "not of this format");
        const std::string text = refusal(name);
        EXPECT_EQ(text.find(lacks) == std::string::npos, present) << text;
        EXPECT_EQ(volume_formats().find(lacks) == std::string::npos, present);
        EXPECT_NE(volume_formats().find(name + 1), std::string::npos);
    }
}

} // namespace
} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
// NRRD, NIfTI, MetaImage and DICOM, written byte by byte. Registered where ITK was found.
#include "tests/support/volume_bytes.hpp"
#include "tests/support/volume_file_test.hpp"

#include <cmath>
#include <functional>
#include <limits>
#include <map>

namespace ockham {
namespace {

using test::dicom;
using test::DicomSlice;
using test::Fields;
using test::kVoxels;
using test::meta;
using test::nifti;
using test::nrrd;

class VolumeItk : public test::VolumeFileTest {};

/// 2 x 3 x 4, spacing 0.5 x 1 x 2.25, the first axis of the data along the world's second.
void expect_placed(const Volume& volume) {
    EXPECT_EQ(volume.dims, glm::uvec3(2, 3, 4));
    const glm::dvec3 spacing(0.5, 1, 2.25), origin(10, -20, 0.125);
    const glm::dmat3 direction(glm::dvec3(0, 1, 0), glm::dvec3(-1, 0, 0), glm::dvec3(0, 0, 1));
    for (int axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(volume.spacing_mm[axis], spacing[axis], 1e-6);
        EXPECT_NEAR(volume.origin_mm[axis], origin[axis], 1e-6);
        EXPECT_LT(glm::length(volume.direction[axis] - direction[axis]), 1e-6) << axis;
    }
}

/// -5, -4, ... with x fastest.
void expect_ramp(const Volume& volume, double first = -5, double step = 1) {
    for (int i = 0; i < 24; ++i) {
        ASSERT_EQ(volume.at({i % 2, i / 2 % 3, i / 6}), first + step * i) << i;
    }
}

TEST_F(VolumeItk, FormatsHonourSpacingDirectionAndOrigin) {
    scribble("a.nrrd", nrrd());
    scribble("a.nhdr", nrrd({{"data file", "a.raw"}}, ""));
    scribble("a.raw", kVoxels);
    scribble("a.mha", meta());
    scribble("a.mhd", meta({{"ElementDataFile", "a.raw"}}, ""));
    scribble("a.nii", nifti());
    scribble("A.NRRD", nrrd());
    for (const char* name : {"a.nrrd", "a.nhdr", "a.mha", "a.mhd", "a.nii", "A.NRRD"}) {
        SCOPED_TRACE(name);
        const Volume volume = load(name);
        EXPECT_EQ(volume.type, VoxelType::int16);
        expect_placed(volume);
        expect_ramp(volume);
        EXPECT_TRUE(volume.notes.empty()) << volume.notes[0];
    }
}

TEST_F(VolumeItk, WithoutSpacingOneMillimetreIsNoted) {
    scribble("a.nrrd", nrrd({{"space", ""}, {"space directions", ""}, {"space origin", ""}}));
    scribble("a.mha", meta({{"ElementSpacing", ""}}));
    for (const char* name : {"a.nrrd", "a.mha"}) {
        const Volume volume = load(name);
        EXPECT_EQ(volume.spacing_mm, glm::dvec3(1));
        ASSERT_EQ(volume.notes.size(), 1u);
        EXPECT_EQ(volume.notes[0], "it states no spacing: 1 mm along each axis is taken");
    }
}

TEST_F(VolumeItk, OtherTypesAreConvertedWithANote) {
    struct Case {
        const char* type;
        std::string voxels;
        VoxelType expected;
        double first;
    };
    const Case cases[] = {
        {"uchar", test::ramp<std::uint8_t>(24, 230), VoxelType::uint8, 230},
        {"ushort", test::ramp<std::uint16_t>(24, 65000), VoxelType::uint16, 65000},
        {"float", test::ramp<float>(24, 0.25f), VoxelType::float32, 0.25},
        {"signed char", test::ramp<std::int8_t>(24, -128), VoxelType::int16, -128},
        {"int", test::ramp<std::int32_t>(24, -32768), VoxelType::int16, -32768},
        {"uint", test::ramp<std::uint32_t>(24, 65512), VoxelType::uint16, 65512},
        {"int", test::ramp<std::int32_t>(24, -40000), VoxelType::float32, -40000},
        {"int64", test::ramp<std::int64_t>(24, 65000), VoxelType::uint16, 65000},
        {"double", test::ramp<double>(24, -0.5), VoxelType::float32, -0.5},
    };
    for (const Case& test : cases) {
        SCOPED_TRACE(test.type);
        scribble("a.nrrd", nrrd({{"type", test.type}}, test.voxels));
        const Volume volume = load("a.nrrd");
        EXPECT_EQ(volume.type, test.expected);
        expect_ramp(volume, test.first);
        const bool same = &test < cases + 3; // the first three are kept as they are
        ASSERT_EQ(volume.notes.size(), same ? 0u : 1u);
        if (!same)
            expect_contains(volume.notes[0], fmt::format("are kept as {}", name_of(test.expected)));
    }
}

TEST_F(VolumeItk, NiftiScalesItsValues) {
    scribble("a.nii", nifti(0.5f, 100));
    const Volume volume = load("a.nii");
    expect_ramp(volume, 97.5, 0.5);
    expect_placed(volume);
}

TEST_F(VolumeItk, RefusesWhatIsNoScalarVolume) {
    scribble("a.nrrd",
        nrrd({{"dimension", "4"}, {"sizes", "3 2 3 4"}, {"kinds", "vector domain domain domain"},
                 {"space directions", "none (1,0,0) (0,1,0) (0,0,1)"}},
            test::ramp<std::int16_t>(72, 0)));
    expect_contains(refusal("a.nrrd"), "a.nrrd': its voxels have 3 components (");
    scribble("a.mha", meta({{"ElementNumberOfChannels", "2"}}, kVoxels + kVoxels));
    expect_contains(refusal("a.mha"), "its voxels have 2 components (vector), expected 1; save one "
                                      "of them, or their length");
    scribble("a.mha", meta({{"NDims", "4"}, {"DimSize", "2 3 2 2"}, {"TransformMatrix", ""},
                          {"Offset", "0 0 0 0"}, {"ElementSpacing", "1 1 1 1"}}));
    expect_contains(refusal("a.mha"), "it has 4 dimensions, the size of dimension 4 is 2, expected "
                                      "3 dimensions; save one of these volumes alone");
    scribble("a.nrrd", nrrd({{"type", "float"}},
                           test::ramp<float>(23, 0) +
                               test::ramp<float>(1, std::numeric_limits<float>::infinity())));
    expect_contains(refusal("a.nrrd"), "voxel (1, 2, 3) is inf");
}

TEST_F(VolumeItk, RefusesMoreThanItHoldsBeforeMakingRoom) {
    scribble("a.nrrd", nrrd({{"sizes", "4096 4096 4096"}}));
    expect_contains(refusal("a.nrrd"), "it states 4096 x 4096 x 4096 voxels");
    scribble("a.nrrd", nrrd({{"sizes", "1024 1024 1024"}}));
    expect_contains(
        refusal("a.nrrd"), "voxels of type short take 2147483648 bytes, but 48 are there");
    scribble("a.mhd", meta({{"DimSize", "1024 1024 1024"}, {"ElementDataFile", "a.raw"}}, ""));
    scribble("a.raw", kVoxels);
    expect_contains(refusal("a.mhd"), "it is damaged or cut off");
}

TEST_F(VolumeItk, DataStaysInTheFolder) {
    for (const char* name : {"../a.raw", "/etc/hostname", "sub/../../a.raw"}) {
        scribble("a.mhd", meta({{"ElementDataFile", name}}, ""));
        scribble("a.nhdr", nrrd({{"data file", name}}, ""));
        for (const char* header : {"a.mhd", "a.nhdr"}) {
            expect_contains(
                refusal(header), fmt::format("the file '{}' that it names is outside of "
                                             "its folder",
                                     name));
        }
    }
    scribble("a.mhd", meta({{"ElementDataFile", "LIST"}}, "../a.raw\n../b.raw\n"));
    expect_contains(refusal("a.mhd"), "the file '../a.raw' that it names is outside");
}

Fields packed(const std::string& zlib, const std::string& file = "LOCAL") {
    return {{"CompressedData", "True"}, {"CompressedDataSize", fmt::to_string(zlib.size())},
        {"ElementDataFile", file}};
}

TEST_F(VolumeItk, PackedVoxels) {
    scribble("a.nrrd", nrrd({{"encoding", "gzip"}}, test::gzip(kVoxels)));
    const std::string zlib = test::gzip(kVoxels, 15);
    scribble("a.mha", meta(packed(zlib), zlib));
    scribble("a.mhd", meta(packed(zlib, "a.zraw"), ""));
    scribble("a.zraw", zlib);
    scribble("a.nii.gz", test::gzip(nifti()));
    for (const char* name : {"a.nrrd", "a.mha", "a.mhd", "a.nii.gz"}) {
        SCOPED_TRACE(name);
        const Volume volume = load(name);
        expect_placed(volume);
        expect_ramp(volume);
    }
}

/// MetaIO and NIfTI's library read zeros where there is nothing, and damaged streams as they come.
TEST_F(VolumeItk, FilesCutOffAnywhereAreRefused) {
    const std::string zlib = test::gzip(kVoxels, 15);
    const std::pair<std::string, std::string> files[] = {{"a.nrrd", nrrd()}, {"a.mha", meta()},
        {"a.nii", nifti()}, {"a.nii.gz", test::gzip(nifti())}, {"b.mha", meta(packed(zlib), zlib)},
        {"b.nrrd", nrrd({{"encoding", "gzip"}}, test::gzip(kVoxels))}};
    std::vector<std::string> loaded;
    testing::internal::CaptureStderr(); // the libraries' own words
    testing::internal::CaptureStdout();
    for (const auto& [name, bytes] : files) {
        for (std::size_t size = 0; size < bytes.size(); size += size < 150 ? 7 : 1) {
            scribble(name, bytes.substr(0, size));
            if (refusal(name) == "loaded") loaded.push_back(fmt::format("{} at {}", name, size));
        }
    }
    testing::internal::GetCapturedStderr();
    testing::internal::GetCapturedStdout();
    EXPECT_TRUE(loaded.empty()) << loaded.size() << " loaded, as " << loaded[0];
    scribble("a.mha", meta().substr(0, meta().size() - 1));
    expect_contains(refusal("a.mha"), "2 x 3 x 4 voxels of type short take 48 bytes, but 47 are "
                                      "there; it is damaged or cut off");
    scribble("a.nii", nifti().substr(0, 399));
    expect_contains(refusal("a.nii"), "take 400 bytes, but 399 are there");
}

TEST_F(VolumeItk, DamagedStreamsAreRefused) {
    std::string zlib = test::gzip(kVoxels, 15);
    scribble("a.mha", meta({{"CompressedData", "True"}}, zlib));
    expect_contains(refusal("a.mha"), "CompressedDataSize is missing; write it anew with that");
    zlib[zlib.size() - 8] ^= 0x55;
    scribble("a.mha", meta(packed(zlib), zlib));
    expect_contains(refusal("a.mha"), "its gzip data is damaged (");
    std::string gzip = test::gzip(kVoxels);
    gzip[gzip.size() - 5] ^= 0x55; // the checksum
    scribble("a.nrrd", nrrd({{"encoding", "gzip"}}, gzip));
    expect_contains(refusal("a.nrrd"), "its gzip data is damaged (incorrect data check)");
    gzip = test::gzip(nifti());
    gzip[gzip.size() - 5] ^= 0x55;
    scribble("a.nii.gz", gzip);
    EXPECT_NE(refusal("a.nii.gz"), "loaded");
}

// ---- DICOM
class VolumeDicom : public test::VolumeFileTest {
protected:
    /// Four slices 2.25 mm apart along z, with `change` made to each; the last comes first.
    void write_series(
        const std::function<void(int, DicomSlice&)>& change = [](int, DicomSlice&) {}) {
        for (int i = 0; i < 4; ++i) {
            DicomSlice slice;
            slice.number = i + 1;
            slice.first = static_cast<std::uint16_t>(1000 + 12 * i);
            slice.position = fmt::format("10\\-20\\{}", 2.25 * i);
            change(i, slice);
            scribble(fmt::format("d/{}_{}", 9 - i, slice.series), dicom(slice));
        }
    }
};

TEST_F(VolumeDicom, ASeriesInOrderOfPlaceWithRescaledValues) {
    write_series();
    scribble("d/readme.txt", "not a slice");
    const Volume volume = load("d");
    EXPECT_EQ(volume.dims, glm::uvec3(4, 3, 4));
    EXPECT_EQ(volume.type, VoxelType::int16);
    EXPECT_EQ(volume.spacing_mm, glm::dvec3(0.5, 0.75, 2.25));
    EXPECT_EQ(volume.direction, glm::dmat3(1));
    EXPECT_EQ(volume.origin_mm, glm::dvec3(10, -20, 0));
    for (int i = 0; i < 48; ++i) {
        ASSERT_EQ(volume.at({i % 4, i / 4 % 3, i / 12}), 1000 - 1024 + i);
    }
    EXPECT_TRUE(volume.notes.empty()) << volume.notes[0];
}

TEST_F(VolumeDicom, ObliqueSlicesGiveTheirNormal) {
    // Rows run along y, columns down: slices advance along -x.
    write_series([](int i, DicomSlice& slice) {
        slice.orientation = "0\\1\\0\\0\\0\\-1";
        slice.position = fmt::format("{}\\5\\6", 3 - 1.5 * i);
    });
    const Volume volume = load("d");
    EXPECT_EQ(volume.direction[0], glm::dvec3(0, 1, 0));
    EXPECT_EQ(volume.direction[1], glm::dvec3(0, 0, -1));
    EXPECT_EQ(volume.direction[2], glm::dvec3(-1, 0, 0));
    EXPECT_EQ(volume.spacing_mm, glm::dvec3(0.5, 0.75, 1.5));
    EXPECT_EQ(volume.origin_mm, glm::dvec3(3, 5, 6));
}

TEST_F(VolumeDicom, TheLargestSeriesUnlessOneIsNamed) {
    write_series();
    DicomSlice scout;
    scout.series = "1.2.3.0";
    scout.first = 7;
    scribble("d/0", dicom(scout));
    scribble("d/1", dicom({.number = 9, .columns = 5})); // another size, the same UID
    const Volume volume = load("d");
    EXPECT_EQ(volume.dims.z, 4u);
    ASSERT_EQ(volume.notes.size(), 1u);
    EXPECT_EQ(volume.notes[0], "DICOM series '1.2.3.1' is read; also there: '1.2.3.0', "
                               "'1.2.3.1-2' (append #NAME to the path)");
    EXPECT_EQ(load("d#1.2.3.0").at({0, 0, 0}), 7 - 1024);
    EXPECT_EQ(load("d#1.2.3.1-2").dims, glm::uvec3(5, 3, 1));
    expect_contains(refusal("d#4.5"), "it has no DICOM series '4.5'; it has '1.2.3.1', '1.2.3.0'");
}

TEST_F(VolumeDicom, ASingleFile) {
    scribble("a.dcm", dicom({.position = "1\\2\\3"}));
    const Volume volume = load("a.dcm");
    EXPECT_EQ(volume.dims, glm::uvec3(4, 3, 1));
    EXPECT_EQ(volume.spacing_mm, glm::dvec3(0.5, 0.75, 1));
    ASSERT_EQ(volume.notes.size(), 1u);
    EXPECT_EQ(volume.notes[0], "a single slice, taken to be 1 mm thick");
    EXPECT_EQ(volume.at({3, 2, 0}), 100 + 11 - 1024);
}

TEST_F(VolumeDicom, SlicesWithScalesOfTheirOwnBecomeFloats) {
    write_series([](int i, DicomSlice& slice) { slice.slope = i == 2 ? 0.5 : 1; });
    const Volume volume = load("d");
    EXPECT_EQ(volume.type, VoxelType::float32);
    EXPECT_EQ(volume.at({0, 0, 1}), 1012 - 1024);
    EXPECT_EQ(volume.at({1, 0, 2}), 1025 * 0.5 - 1024);
}

TEST_F(VolumeDicom, UnevenAndTiltedSlicesAreNoted) {
    write_series([](int i, DicomSlice& slice) {
        slice.position = fmt::format("0\\0\\{}", i == 3 ? 9.0 : 2.0 * i);
    });
    Volume volume = load("d");
    EXPECT_EQ(volume.spacing_mm.z, 3.0);
    ASSERT_EQ(volume.notes.size(), 1u);
    EXPECT_EQ(volume.notes[0], "its slices are 2 to 5 mm apart; the mean, 3 mm, is taken for all");
    write_series([](int i, DicomSlice& slice) {
        slice.position = fmt::format("0\\{}\\{}", 1.0 * i, 2.0 * i);
    });
    volume = load("d");
    EXPECT_EQ(volume.spacing_mm.z, 2.0);
    ASSERT_EQ(volume.notes.size(), 1u);
    EXPECT_EQ(volume.notes[0], "its gantry tilt of 26.6 degrees is not honoured");
}

TEST_F(VolumeDicom, RefusesWhatIsNoVolume) {
    std::filesystem::create_directories(file("empty"));
    expect_contains(refusal("empty"), "empty': it has no DICOM series");
    write_series([](int i, DicomSlice& slice) { slice.position = fmt::format("0\\0\\{}", i / 2); });
    expect_contains(refusal("d"), "slices 1 and 2 are 0 mm apart, expected different places; the "
                                  "series holds several volumes or no positions");
    scribble("a.dcm", dicom({.colours = 3}));
    expect_contains(refusal("a.dcm"), "its voxels have 3 components (rgb), expected 1");
    scribble("a.dcm", "DICM");
    expect_contains(refusal("a.dcm"), "the mark DICM is not at byte 128; it is no DICOM file");
}

TEST_F(VolumeDicom, FilesCutOffAreRefused) {
    const std::string bytes = dicom({});
    testing::internal::CaptureStderr(); // the libraries' own words
    testing::internal::CaptureStdout();
    std::vector<std::size_t> loaded;
    for (std::size_t size = 0; size < bytes.size(); size += 3) {
        scribble("a.dcm", bytes.substr(0, size));
        if (refusal("a.dcm") == "loaded") loaded.push_back(size);
    }
    testing::internal::GetCapturedStderr();
    testing::internal::GetCapturedStdout();
    EXPECT_TRUE(loaded.empty()) << loaded.size() << " of " << bytes.size() << ", " << loaded[0];
    scribble("a.dcm", bytes.substr(0, bytes.size() - 1));
    expect_contains(
        refusal("a.dcm"), fmt::format("its DICOM element at byte {} lies beyond its end; "
                                      "it has {} bytes and is damaged or cut off",
                              bytes.size() - 36, bytes.size() - 1));
}

} // namespace
} // namespace ockham

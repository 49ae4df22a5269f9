// SPDX-License-Identifier: Apache-2.0
#include "framework/io/volume_file.hpp"

#include "framework/io/volume_child.hpp"
#include "framework/io/volume_readers.hpp"
#include "framework/scene/builtin_volume.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <string_view>

namespace ockham {
namespace {

namespace fs = std::filesystem;

// From the build: which of the optional libraries it found.
constexpr bool kItk = OCKHAM_WITH_ITK;
constexpr bool kOpenVdb = OCKHAM_WITH_OPENVDB;
constexpr bool kNanoVdb = OCKHAM_WITH_NANOVDB;

constexpr const char* kItkFormats = ".nrrd .nhdr .nii .nii.gz .mhd .mha, DICOM folders, .dcm";
constexpr const char* kItkLacks = "ITK, install libinsighttoolkit5-dev";
constexpr const char* kOpenVdbLacks = "OpenVDB, install libopenvdb-dev and libboost-dev";
constexpr const char* kNanoVdbLacks = "NanoVDB, install libnanovdb-dev";

struct Source {
    fs::path path;
    std::string part; ///< what follows '#'
};

/// '#' may also belong to the name of a file.
Source parse(const std::string& text) {
    const std::size_t mark = text.rfind('#');
    std::error_code ignored;
    if (mark == std::string::npos || fs::exists(text, ignored)) return {text, ""};
    return {text.substr(0, mark), text.substr(mark + 1)};
}

bool ends_with(const fs::path& path, std::initializer_list<std::string_view> endings) {
    std::string name = path.filename().string();
    std::ranges::transform(name, name.begin(),
        [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    return std::ranges::any_of(endings, [&](std::string_view end) { return name.ends_with(end); });
}

[[noreturn]] void fail_without(const fs::path& path, const char* what) {
    fail_input("cannot load volume '{}': built without {} and build again", path.string(), what);
}

Volume read(const Source& source) {
    const fs::path& path = source.path;
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    if (!fs::exists(status)) {
        fail_input("cannot load volume '{}': {}", path.string(),
            error ? error.message() : "no such file or folder");
    }
    if (!fs::is_regular_file(status) && !fs::is_directory(status)) {
        fail_input("cannot load volume '{}': it is neither a file nor a folder", path.string());
    }
    // Discarded branches need no reader to link.
    if (ends_with(path, {".dcm"}) || fs::is_directory(status)) {
        if constexpr (kItk)
            return load_in_child(
                path, Memory::by_file_size, [&] { return load_dicom_volume(path, source.part); });
        fail_without(path, kItkLacks);
    }
    if (ends_with(path, {".vdb"})) {
        if constexpr (kOpenVdb)
            return load_in_child(
                path, Memory::any, [&] { return load_openvdb_volume(path, source.part); });
        fail_without(path, kOpenVdbLacks);
    }
    if (ends_with(path, {".nvdb"})) {
        if constexpr (kNanoVdb)
            return load_in_child(
                path, Memory::any, [&] { return load_nanovdb_volume(path, source.part); });
        fail_without(path, kNanoVdbLacks);
    }
    if (!source.part.empty()) {
        fail_input("cannot load volume '{}': its format has no parts to choose, remove '#{}'",
            path.string(), source.part);
    }
    if (ends_with(path, {".json"})) return load_raw_volume(path);
    if (ends_with(path, {".nrrd", ".nhdr", ".nii", ".nii.gz", ".mhd", ".mha"})) {
        if constexpr (kItk)
            return load_in_child(path, Memory::any, [&] { return load_itk_volume(path); });
        fail_without(path, kItkLacks);
    }
    if (ends_with(path, {".raw", ".raw.gz"})) {
        fail_input("cannot load volume '{}': raw voxels need a .json beside them that states file, "
                   "dims, type and spacing_mm; load that",
            path.string());
    }
    fail_input("cannot load volume '{}': the end of its name is not known; expected {}",
        path.string(), volume_formats());
}

/// The world's axes are taken along the data's, whatever angles those have.
void note_shear(Volume& volume) {
    double worst = 0;
    for (int axis = 0; axis < 3; ++axis) {
        worst = std::max(
            worst, std::abs(glm::dot(volume.direction[axis], volume.direction[(axis + 1) % 3])));
    }
    if (worst <= 1e-3) return;
    volume.notes.push_back(fmt::format("its axes are {:.2f} degrees off right angles, which is not "
                                       "honoured",
        glm::degrees(std::asin(std::min(worst, 1.0)))));
}

/// "builtin:NAME" or "builtin:NAME:SIDE".
Volume builtin(const std::string& source) {
    const std::size_t colon = source.find(':', std::strlen("builtin:"));
    if (colon == std::string::npos) return builtin_volume(source);
    const char *first = source.data() + colon + 1, *last = source.data() + source.size();
    std::uint32_t side = 0;
    const auto [end, error] = std::from_chars(first, last, side);
    if (error != std::errc{} || end != last)
        fail_input("volume '{}': expected builtin:NAME:SIDE, with a number of voxels", source);
    return builtin_volume(source.substr(0, colon), side);
}

} // namespace

Volume load_volume(const std::string& source) {
    if (source.starts_with("builtin:")) return builtin(source);
    Volume volume = read(parse(source));
    volume.name = source;
    validate(volume);
    note_shear(volume);
    return volume;
}

std::string volume_formats() {
    std::string text = "builtin:NAME, .json (raw voxels)";
    std::string lacks;
    const auto add = [&](bool has, const char* formats, const char* without) {
        if (has)
            text += fmt::format(", {}", formats);
        else
            lacks += fmt::format("; no {}: built without {}", formats, without);
    };
    add(kItk, kItkFormats, kItkLacks);
    add(kOpenVdb, ".vdb", kOpenVdbLacks);
    add(kNanoVdb, ".nvdb", kNanoVdbLacks);
    return text + lacks;
}

} // namespace ockham

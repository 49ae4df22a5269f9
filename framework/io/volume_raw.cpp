// SPDX-License-Identifier: Apache-2.0
// Raw voxels described by a JSON file beside them.
#include "framework/core/file.hpp"
#include "framework/core/json_object.hpp"
#include "framework/io/gzip.hpp"
#include "framework/io/volume_readers.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace ockham {
namespace {

namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little, "raw voxels are little endian");

constexpr double kLargest = std::numeric_limits<double>::max();
constexpr const char* kKeys[] = {"file", "dims", "type", "spacing_mm", "direction", "origin_mm"};

StatedDims read_dims(const JsonObject& sidecar) {
    constexpr const char* kExpected = "three whole numbers of at least 1";
    const auto sides = sidecar.numbers<3>("dims", 1, 0x1p53, kExpected);
    StatedDims dims{};
    for (std::size_t i = 0; i < dims.size(); ++i) {
        if (sides[i] != std::floor(sides[i])) sidecar.refuse("dims", kExpected);
        dims[i] = static_cast<std::uint64_t>(sides[i]);
    }
    return dims;
}

VoxelType read_type(const JsonObject& sidecar) {
    const std::string name = sidecar.text("type");
    for (const VoxelType type :
        {VoxelType::uint8, VoxelType::int16, VoxelType::uint16, VoxelType::float32}) {
        if (name == name_of(type)) return type;
    }
    sidecar.refuse("type", "uint8, int16, uint16 or float32");
}

glm::dvec3 read_vector(const JsonObject& sidecar, const char* key) {
    const auto numbers = sidecar.numbers<3>(key, -kLargest, kLargest, "three numbers");
    return {numbers[0], numbers[1], numbers[2]};
}

void note_unknown(const nlohmann::json& sidecar, std::vector<std::string>& notes) {
    std::vector<std::string> unknown;
    for (const auto& [key, value] : sidecar.items()) {
        if (std::ranges::find(kKeys, key) == std::end(kKeys)) unknown.push_back(key);
    }
    if (unknown.empty()) return;
    notes.push_back(
        fmt::format("the sidecar's keys '{}' are not read", fmt::join(unknown, "', '")));
}

/// "64 x 64 x 93 voxels of uint16 take 64 * 64 * 93 * 2 = 761856 bytes".
std::string formula(const Volume& volume) {
    const glm::uvec3 d = volume.dims;
    return fmt::format("{0} x {1} x {2} voxels of {3} take {0} * {1} * {2} * {4} = {5}", d.x, d.y,
        d.z, name_of(volume.type), bytes_of(volume.type), bytes_of_voxels(volume));
}

/// The voxels of `volume`, whose dims and type are set, as they stand in the file.
void read_voxels(Volume& volume, const std::string& sidecar, const fs::path& path) {
    const std::uint64_t bytes = bytes_of_voxels(volume);
    const bool packed = path.extension() == ".gz";
    std::error_code error;
    const std::uint64_t stored = fs::file_size(path, error); // read_file() says what is wrong
    const auto mismatch = [&](const std::string& found) {
        fail_input("cannot load volume '{}': '{}' has {}, but {}: correct dims or type", sidecar,
            path.filename().string(), found, formula(volume));
    };
    if (!error && !packed && stored != bytes) mismatch(fmt::format("{} bytes", stored));
    if (!error && packed && bytes / kMaxDeflateRatio > stored) {
        mismatch(fmt::format(
            "{} bytes of gzip, at most {} unpacked", stored, stored * kMaxDeflateRatio));
    }
    volume.voxels = read_file(path, std::max(bytes, stored));
    if (!packed) return;

    std::vector<std::byte> unpacked(bytes);
    std::uint64_t found = 0;
    try {
        found = inflate(volume.voxels, unpacked);
    } catch (const Error& problem) {
        fail_input("cannot load volume '{}': cannot unpack '{}': {}; {}", sidecar,
            path.filename().string(), problem.what(), formula(volume));
    }
    if (found > bytes) mismatch(fmt::format("more than {} bytes unpacked", bytes));
    if (found < bytes) mismatch(fmt::format("{} bytes unpacked", found));
    volume.voxels = std::move(unpacked);
}

} // namespace

Volume load_raw_volume(const fs::path& path) {
    const nlohmann::json json = parse_json(path, "volume");
    const JsonObject sidecar(json, "volume", path.string());
    Volume volume;
    volume.type = read_type(sidecar);
    volume.dims = checked_dims(path.string(), read_dims(sidecar));
    volume.spacing_mm = read_vector(sidecar, "spacing_mm");
    if (sidecar.has("direction")) {
        const auto d =
            sidecar.numbers<9>("direction", -1.5, 1.5, "three unit vectors, nine numbers");
        volume.direction = glm::dmat3(d[0], d[1], d[2], d[3], d[4], d[5], d[6], d[7], d[8]);
    }
    if (sidecar.has("origin_mm")) volume.origin_mm = read_vector(sidecar, "origin_mm");
    note_unknown(json, volume.notes);
    read_voxels(volume, path.string(), path_beside(path, sidecar.text("file")));
    return volume;
}

} // namespace ockham

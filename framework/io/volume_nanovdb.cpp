// SPDX-License-Identifier: Apache-2.0
// Float grids of NanoVDB files, made dense. The library's own file reader trusts sizes that files
// state, so the container is read here, and the grid checked before it is walked.
#include "framework/core/file.hpp"
#include "framework/io/gzip.hpp"
#include "framework/io/volume_readers.hpp"

// clang-format off
#include <nanovdb/util/IO.h>
#include <nanovdb/util/GridValidator.h> // relies on the <iostream> of IO.h
// clang-format on

#include <algorithm>
#include <cstring>
#include <span>

namespace ockham {
namespace {

namespace io = nanovdb::io;

/// One grid as the file holds it.
struct StoredGrid {
    std::string name;
    io::MetaData meta{};
    std::span<const std::byte> payload;
};

/// Takes pieces off the front of a file; throws where there are not enough bytes.
class Reader {
public:
    Reader(std::span<const std::byte> bytes, const std::string& file) : rest_(bytes), file_(file) {}
    bool empty() const { return rest_.empty(); }
    std::span<const std::byte> take(std::uint64_t count) {
        if (count > rest_.size()) {
            fail_input("cannot load volume '{}': it ends too early: {} bytes are expected where {} "
                       "are left",
                file_, count, rest_.size());
        }
        const auto piece = rest_.first(count);
        rest_ = rest_.subspan(count);
        return piece;
    }
    template <class T>
    T take() {
        T value{};
        std::memcpy(static_cast<void*>(&value), take(sizeof(T)).data(), sizeof(T));
        return value;
    }

private:
    std::span<const std::byte> rest_;
    const std::string& file_;
};

/// Segments, each a header, the descriptions of its grids and then their voxels.
std::vector<StoredGrid> grids_of(std::span<const std::byte> bytes, const std::string& file) {
    Reader reader(bytes, file);
    std::vector<StoredGrid> grids;
    while (!reader.empty()) {
        const auto header = reader.take<io::Header>();
        if (header.magic != NANOVDB_MAGIC_NUMBER) {
            fail_input("cannot load volume '{}': a segment begins with {:016x}, expected NanoVDB's "
                       "{:016x}",
                file, header.magic, std::uint64_t{NANOVDB_MAGIC_NUMBER});
        }
        const std::size_t first = grids.size();
        for (int i = 0; i < header.gridCount; ++i) {
            StoredGrid grid;
            grid.meta = reader.take<io::MetaData>();
            const auto name = reader.take(grid.meta.nameSize);
            grid.name.assign(reinterpret_cast<const char*>(name.data()), name.size());
            grid.name.resize(std::strlen(grid.name.c_str())); // it ends with a 0
            grid.meta.codec = header.codec;
            grids.push_back(std::move(grid));
        }
        for (std::size_t i = first; i < grids.size(); ++i) {
            grids[i].payload = reader.take(grids[i].meta.fileSize);
        }
    }
    return grids;
}

nanovdb::GridHandle<> unpack(const StoredGrid& grid, const std::string& file) {
    const std::uint64_t bytes = grid.meta.gridSize;
    std::span<const std::byte> payload = grid.payload;
    const bool packed = grid.meta.codec == io::Codec::ZIP;
    if (!packed && grid.meta.codec != io::Codec::NONE) {
        fail_input("cannot load volume '{}': it is compressed by {}, expected zip or none; write "
                   "it anew with zip",
            file, grid.meta.codec == io::Codec::BLOSC ? "blosc" : "an unknown codec");
    }
    const std::uint64_t at_most = packed ? payload.size() * kMaxDeflateRatio : payload.size();
    if (bytes > at_most ||
        bytes < sizeof(nanovdb::NanoGrid<float>) + sizeof(nanovdb::NanoTree<float>)) {
        fail_input(
            "cannot load volume '{}': grid '{}' states {} bytes, but {} are stored; the file "
            "is damaged",
            file, grid.name, bytes, payload.size());
    }
    nanovdb::GridHandle<> handle(nanovdb::HostBuffer::create(bytes));
    const std::span<std::byte> room(reinterpret_cast<std::byte*>(handle.data()), bytes);
    if (!packed) {
        std::ranges::copy(payload.first(bytes), room.begin());
        return handle;
    }
    payload = payload.subspan(std::min<std::size_t>(sizeof(std::uint64_t), payload.size()));
    const std::uint64_t found =
        inflate(payload, room); // the size of the packed bytes precedes them
    if (found != bytes) {
        fail_input("cannot load volume '{}': grid '{}' states {} bytes, but {} are unpacked; the "
                   "file is damaged",
            file, grid.name, bytes, found > bytes ? "more" : fmt::to_string(found));
    }
    return handle;
}

template <class Build>
Volume dense(const nanovdb::NanoGrid<Build>& grid, std::uint64_t bytes, const std::string& file) {
    const auto damaged = [&](const std::string& what) {
        fail_input(
            "cannot load volume '{}': grid '{}' is damaged: {}", file, grid.gridName(), what);
    };
    if (grid.gridSize() != bytes) {
        damaged(fmt::format("it states {} bytes and has {}", grid.gridSize(), bytes));
    }
    // Coarse first: the detailed check follows pointers that the coarse one vouches for.
    for (const bool detailed : {false, true}) {
        if (const auto what = nanovdb::GridValidator<Build>::check(grid, detailed); !what.empty()) {
            damaged(what);
        }
    }
    const auto box = grid.tree().bbox();
    Volume volume = sparse_box(file, {box.min()[0], box.min()[1], box.min()[2]},
        {box.max()[0], box.max()[1], box.max()[2]}, grid.tree().background());
    auto accessor = grid.getAccessor();
    std::byte* into = volume.voxels.data();
    for (int z = box.min()[2] - 1; z <= box.max()[2] + 1; ++z) {
        for (int y = box.min()[1] - 1; y <= box.max()[1] + 1; ++y) {
            for (int x = box.min()[0] - 1; x <= box.max()[0] + 1; ++x) {
                const float value = accessor.getValue(nanovdb::Coord(x, y, z));
                std::memcpy(into, &value, sizeof(value));
                into += sizeof(value);
            }
        }
    }
    const auto world = [&](int x, int y, int z) {
        const auto p = grid.indexToWorld(nanovdb::Vec3d(x, y, z));
        return glm::dvec3(p[0], p[1], p[2]);
    };
    const int x = box.min()[0] - 1, y = box.min()[1] - 1, z = box.min()[2] - 1;
    const glm::dvec3 origin = world(x, y, z);
    place_sparse(volume,
        glm::dmat3(
            world(x + 1, y, z) - origin, world(x, y + 1, z) - origin, world(x, y, z + 1) - origin),
        origin);
    return volume;
}

} // namespace

Volume load_nanovdb_volume(const std::filesystem::path& path, const std::string& wanted) {
    const std::string file = path.string();
    const std::vector<std::byte> bytes = read_file(path);
    const std::vector<StoredGrid> grids = grids_of(bytes, file);
    std::vector<std::string> names, notes;
    for (const StoredGrid& grid : grids) names.push_back(grid.name);
    const StoredGrid& chosen = grids[choose_part(file, "grid", names, wanted, notes)];
    const nanovdb::GridHandle<> handle = unpack(chosen, file);

    const auto load = [&]<class Build>(const Build*) {
        Volume volume = dense(*handle.grid<Build>(), chosen.meta.gridSize, file);
        volume.notes.insert(volume.notes.begin(), notes.begin(), notes.end());
        return volume;
    };
    const nanovdb::GridType type = handle.gridType();
    if (type == nanovdb::GridType::Float) return load(static_cast<const float*>(nullptr));
    if (type == nanovdb::GridType::Fp4) return load(static_cast<const nanovdb::Fp4*>(nullptr));
    if (type == nanovdb::GridType::Fp8) return load(static_cast<const nanovdb::Fp8*>(nullptr));
    if (type == nanovdb::GridType::Fp16) return load(static_cast<const nanovdb::Fp16*>(nullptr));
    if (type == nanovdb::GridType::FpN) return load(static_cast<const nanovdb::FpN*>(nullptr));
    fail_input("cannot load volume '{}': grid '{}' has values of type {}, expected float; choose "
               "another grid or convert it",
        file, chosen.name,
        type < nanovdb::GridType::End ? nanovdb::toStr(type) : "unknown to this version");
}

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
// Sparse float grids of OpenVDB files, made dense.
#include "framework/io/volume_readers.hpp"

#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Dense.h>

#include <fstream>
#include <new>

namespace ockham {
namespace {

using openvdb::FloatGrid;

glm::ivec3 from(const openvdb::Coord& coord) { return {coord.x(), coord.y(), coord.z()}; }
glm::dvec3 from(const openvdb::Vec3d& vector) { return {vector.x(), vector.y(), vector.z()}; }

/// The voxels from the first to the last active one, and a border of the background.
Volume dense(const FloatGrid& grid, const std::string& file) {
    const openvdb::math::Transform& transform = grid.transform();
    if (!transform.isLinear()) {
        fail_input("cannot load volume '{}': grid '{}' lies in a frustum, expected a regular grid; "
                   "resample it",
            file, grid.getName());
    }
    openvdb::CoordBBox box = grid.evalActiveVoxelBoundingBox();
    Volume volume = sparse_box(file, from(box.min()), from(box.max()), grid.background());
    box.expand(1);
    openvdb::tools::Dense<float, openvdb::tools::LayoutXYZ> voxels(
        box, reinterpret_cast<float*>(volume.voxels.data()));
    openvdb::tools::copyToDense(grid, voxels);

    const openvdb::Vec3d origin = transform.indexToWorld(box.min());
    glm::dmat3 world_from_index;
    for (int axis = 0; axis < 3; ++axis) {
        openvdb::Coord next = box.min();
        next[axis] += 1;
        world_from_index[axis] = from(transform.indexToWorld(next) - origin);
    }
    place_sparse(volume, world_from_index, from(origin));
    return volume;
}

} // namespace

Volume load_openvdb_volume(const std::filesystem::path& path, const std::string& wanted) {
    const std::string name = path.string();
    try {
        openvdb::initialize();
        // All grids from a stream that throws: io::File goes on after the end of a file, with
        // whatever its variables hold, for minutes or into wrong voxels.
        std::ifstream file(path, std::ios::binary);
        file.exceptions(std::ios::failbit | std::ios::badbit | std::ios::eofbit);
        const auto grids = openvdb::io::Stream(file, /*delayLoad=*/false).getGrids();
        std::vector<std::string> names, notes;
        for (const auto& grid : *grids) names.push_back(grid->getName());
        const std::size_t chosen = choose_part(name, "grid", names, wanted, notes);
        const openvdb::GridBase::Ptr grid = (*grids)[chosen];
        const auto floats = openvdb::gridPtrCast<FloatGrid>(grid);
        if (!floats) {
            fail_input("cannot load volume '{}': grid '{}' has values of type {}, expected float; "
                       "choose another grid or convert it",
                name, names[chosen], grid->valueType());
        }
        Volume volume = dense(*floats, name);
        volume.notes.insert(volume.notes.begin(), notes.begin(), notes.end());
        return volume;
    } catch (const Error&) {
        throw;
    } catch (const std::ios::failure&) {
        fail_input("cannot load volume '{}': it cannot be read to the end of its grids; it is "
                   "damaged or cut off",
            name);
    } catch (const std::bad_alloc&) {
        fail_input("cannot load volume '{}': out of memory", name);
    } catch (const std::exception& error) {
        fail_input("cannot load volume '{}': {}", name, error.what());
    }
}

} // namespace ockham

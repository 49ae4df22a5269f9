// SPDX-License-Identifier: Apache-2.0
#include "framework/core/rng.hpp"
#include "framework/runtime/commands.hpp"
#include "passes/volume/majorants.hpp"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/volume_bench.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace ockham {
namespace {

using test::VolumeBench;

/// A volume of a type with random voxels, some of them runs of the extremes, and a scale and offset
/// that are not those of the texels.
Volume random_volume(glm::uvec3 dims, VoxelType type, std::uint64_t seed) {
    Volume volume;
    volume.name = "random";
    volume.dims = dims;
    volume.type = type;
    volume.value_scale = 0.5;
    volume.value_offset = -100;
    volume.voxels.resize(volume.voxel_count() * bytes_of(type));
    Pcg32 rng(seed);
    for (std::size_t i = 0; i < volume.voxel_count(); ++i) {
        // Smooth along z, so that cells differ.
        const std::size_t z = i / (std::size_t{dims.x} * dims.y);
        const std::uint32_t code = (rng.next() >> 20) + static_cast<std::uint32_t>(z) * 900;
        std::byte* voxel = &volume.voxels[i * bytes_of(type)];
        const float real = 1e-3f * static_cast<float>(code) - 7.0f;
        switch (type) {
        case VoxelType::uint8:
            *voxel = static_cast<std::byte>(code >> 8);
            break;
        case VoxelType::uint16:
        case VoxelType::int16:
            std::memcpy(voxel, &code, 2);
            break;
        case VoxelType::float32:
            std::memcpy(voxel, &real, 4);
            break;
        }
    }
    return volume;
}

/// Opacity at random, or 0 but for one narrow spike.
TransferFunction random_transfer(const ValueRange& values, std::uint64_t seed, bool spike) {
    Pcg32 rng(seed);
    const double extent = values.highest - values.lowest;
    if (spike) {
        const double at = values.lowest + extent * rng.uniform(), width = 1e-3 * extent;
        return {{{at - width, 0}, {at, 1}, {at + width, 0}}};
    }
    TransferFunction transfer;
    for (int i = 0; i <= 300; ++i)
        transfer.points.push_back({values.lowest + extent * i / 300, rng.uniform()});
    return transfer;
}

struct Probe {
    float field, sigma_t, majorant;
    std::uint32_t cell;
};

/// Random places, with many on walls of cells, at centres of voxels and at the box's surface.
std::vector<glm::vec3> places_in(glm::uvec3 dims, std::size_t count) {
    Pcg32 rng(3);
    std::vector<glm::vec3> places;
    for (std::size_t i = 0; i < count; ++i) {
        glm::vec3 place;
        for (int axis = 0; axis < 3; ++axis) {
            const auto size = static_cast<float>(dims[axis]);
            const float voxel = std::floor(rng.uniform() * size);
            switch (rng.below(6)) {
            case 0:
                place[axis] = std::floor(voxel / RANGE_CELL) * RANGE_CELL / size;
                break;
            case 1:
                place[axis] = (voxel + 0.5f) / size;
                break;
            case 2:
                place[axis] = static_cast<float>(rng.below(2));
                break;
            default:
                place[axis] = rng.uniform();
            }
        }
        places.push_back(place);
    }
    return places;
}

class MajorantsTest : public test::GpuTest {
protected:
    /// Adds the pass to a bench in the place of what its host has made, and exports both results.
    static Majorants add(VolumeBench& bench, bool surfaces = true) {
        const MajorantsChange changed{bench.graph.add_condition("volume_changed"),
            bench.graph.add_condition("transfer_changed")};
        Majorants out = add_majorants(bench.graph, bench.inputs.facts, bench.inputs.handles,
            bench.inputs.frame, surfaces, changed);
        if (out.ranges) bench.graph.export_resource(out.ranges, "compared");
        if (out.majorants) bench.graph.export_resource(out.majorants, "compared");
        return out;
    }

    /// What the medium is at places, by the majorants of the pass.
    static std::vector<Probe> probe(const Volume& volume, const TransferFunction& transfer,
        const std::vector<glm::vec3>& places) {
        VolumeBench bench(device(), volume, transfer, {});
        bench.inputs.majorants = add(bench).majorants;
        const BufferHandle input = bench.buffer("places", places);
        PassBuilder pass = bench.graph.add_compute_pass("probe");
        read_medium(pass, bench.inputs, {.light = false, .surfaces = false});
        pass.read("places", input);
        const BufferHandle output = pass.write(
            "probes", bench.graph.create_buffer("probes", {places.size() * sizeof(Probe)}));
        const std::string shader =
            bench.inputs.majorants ? "test/probe.comp:grid" : "test/probe.comp";
        pass.record(
            [shader, count = static_cast<std::uint32_t>(places.size())](Commands& commands) {
                commands.dispatch_over({.shader = shader}, {count, 1, 1});
            });
        bench.graph.export_resource(output, "checked");
        bench.execute();
        return bench.read<Probe>(output);
    }
};

TEST_F(MajorantsTest, RangesAndMajorantsAreThoseOfBruteForce) {
    for (const glm::uvec3 dims : {glm::uvec3(1, 1, 1), glm::uvec3(7, 5, 3), glm::uvec3(8, 16, 1),
             glm::uvec3(9, 17, 33), glm::uvec3(64, 64, 64)}) {
        for (const VoxelType type :
            {VoxelType::uint8, VoxelType::uint16, VoxelType::int16, VoxelType::float32}) {
            if (dims.x != 9 && type != VoxelType::uint8 && type != VoxelType::int16) continue;
            SCOPED_TRACE(fmt::format("{} x {} x {} {}", dims.x, dims.y, dims.z, name_of(type)));
            const Volume volume = random_volume(dims, type, 1);
            const bool spike = type == VoxelType::uint16;
            VolumeBench bench(device(), volume, random_transfer(value_range(volume), 2, spike), {});
            const Majorants found = add(bench);
            bench.execute();
            const auto ranges = bench.read<glm::vec2>(found.ranges);
            const std::vector<ValueRange> truth = reference::cell_ranges(volume);
            ASSERT_EQ(ranges.size(), truth.size());
            for (std::size_t i = 0; i < truth.size(); ++i) {
                EXPECT_FLOAT_EQ(ranges[i].x, bench.gpu.texel_of(truth[i].lowest)) << i;
                EXPECT_FLOAT_EQ(ranges[i].y, bench.gpu.texel_of(truth[i].highest)) << i;
            }
            ASSERT_EQ(bool(found.majorants), !bench.inputs.facts.homogeneous);
            if (!found.majorants) continue;
            const auto majorants = bench.read<float>(found.majorants);
            for (std::size_t i = 0; i < truth.size(); ++i) {
                // The margin is for rounding only: 2^-20 of the texel values, 2^-20 of the result.
                const double margin =
                    0x1p-20 *
                    static_cast<double>(glm::max(std::abs(ranges[i].x), std::abs(ranges[i].y))) *
                    (truth[i].highest - truth[i].lowest + 1e-30) /
                    (static_cast<double>(ranges[i].y - ranges[i].x) + 1e-30);
                const double exact = reference::greatest_opacity(bench.gpu.table(), truth[i]);
                const double wider = reference::greatest_opacity(
                    bench.gpu.table(), {truth[i].lowest - margin, truth[i].highest + margin});
                EXPECT_GE(std::max(majorants[i], 0.0f), exact) << i; // less: see below
                EXPECT_LE(majorants[i], wider * (1 + 0x1p-20)) << i;
            }
        }
    }
}

/// Cells, along each axis and diagonally, from an empty one to the nearest that holds something.
int distance_to_anything(const std::vector<float>& majorants, glm::ivec3 cells, glm::ivec3 from) {
    int nearest = 16; // as far as the pass looks
    for (int z = 0, i = 0; z < cells.z; ++z)
        for (int y = 0; y < cells.y; ++y)
            for (int x = 0; x < cells.x; ++x, ++i) {
                const glm::ivec3 away = glm::abs(glm::ivec3(x, y, z) - from);
                if (majorants[std::size_t(i)] > 0)
                    nearest = std::min(nearest, std::max({away.x, away.y, away.z}));
            }
    return nearest;
}

TEST_F(MajorantsTest, EmptyCellsKnowHowFarAllIsEmpty) {
    for (const int grains : {1, 5, 40}) {
        Pcg32 rng(static_cast<std::uint64_t>(grains));
        Volume volume = test::float_volume({330, 61, 40}, [](glm::uvec3) { return 0; });
        auto* voxels = reinterpret_cast<float*>(volume.voxels.data());
        for (int i = 0; i < grains; ++i)
            voxels[rng.below(static_cast<std::uint32_t>(volume.voxel_count()))] = 1;
        VolumeBench bench(device(), volume, test::linear_transfer(), {});
        const Majorants found = add(bench);
        bench.execute();
        const auto majorants = bench.read<float>(found.majorants);
        const glm::ivec3 cells(bench.inputs.facts.cells);
        for (int z = 0, i = 0; z < cells.z; ++z)
            for (int y = 0; y < cells.y; ++y)
                for (int x = 0; x < cells.x; ++x, ++i) {
                    if (majorants[std::size_t(i)] > 0) continue;
                    ASSERT_EQ(majorants[std::size_t(i)],
                        1 - distance_to_anything(majorants, cells, {x, y, z}))
                        << grains << " grains, cell " << x << ' ' << y << ' ' << z;
                }
    }
}

TEST_F(MajorantsTest, NoLookupLeavesItsCellsRange) {
    for (const VoxelType type : {VoxelType::uint8, VoxelType::int16, VoxelType::float32}) {
        SCOPED_TRACE(name_of(type));
        const Volume volume = random_volume({37, 21, 50}, type, 4);
        const TransferFunction transfer = random_transfer(value_range(volume), 5, false);
        const VolumeGpu units(device(), volume, transfer);
        const std::vector<ValueRange> ranges = reference::cell_ranges(volume);
        for (const Probe& probe : probe(volume, transfer, places_in(volume.dims, 200'000))) {
            const float low = units.texel_of(ranges[probe.cell].lowest);
            const float high = units.texel_of(ranges[probe.cell].highest);
            const float slack = 0x1p-22f * std::max(std::abs(low), std::abs(high));
            ASSERT_GE(probe.field, low - slack);
            ASSERT_LE(probe.field, high + slack);
        }
    }
}

TEST_F(MajorantsTest, TheMediumNowhereExceedsThem) {
    for (const VoxelType type : {VoxelType::uint8, VoxelType::int16, VoxelType::float32}) {
        for (std::uint64_t seed = 1; seed <= 4; ++seed) {
            SCOPED_TRACE(fmt::format("{}, seed {}", name_of(type), seed));
            const Volume volume = random_volume({26, 17, 40}, type, seed);
            const TransferFunction transfer =
                random_transfer(value_range(volume), seed, seed % 2 == 0);
            std::size_t in_vacuum = 0;
            for (const Probe& probe : probe(volume, transfer, places_in(volume.dims, 50'000))) {
                ASSERT_LE(probe.sigma_t, probe.majorant);
                in_vacuum += probe.majorant == 0;
            }
            if (seed % 2 == 0) {
                EXPECT_GT(in_vacuum, 0u) << "a spike leaves cells empty";
            }
        }
    }
}

TEST_F(MajorantsTest, OneMajorantOfAHomogeneousMedium) {
    const Volume volume = test::float_volume({20, 20, 20}, [](glm::uvec3) { return 0.7; });
    VolumeBench bench(device(), volume, test::linear_transfer(), {});
    EXPECT_TRUE(bench.inputs.facts.homogeneous);
    const Majorants found = add(bench, false);
    EXPECT_FALSE(found.ranges);
    EXPECT_FALSE(found.majorants);
    for (const Probe& probe :
        probe(volume, test::linear_transfer(), places_in(volume.dims, 1000))) {
        EXPECT_NEAR(probe.sigma_t, 70.0f, 1e-4f);
        EXPECT_LE(probe.sigma_t, probe.majorant);
        EXPECT_NEAR(probe.majorant, 70.0f, 1e-4f);
    }
}

TEST_F(MajorantsTest, SurfacesNeedRangesWhateverTheMediumIs) {
    const Volume volume = test::float_volume({20, 20, 20}, [](glm::uvec3 v) { return float(v.x); });
    VolumeBench bench(device(), volume, TransferFunction{{{.value = 0, .opacity = 0}}}, {});
    EXPECT_TRUE(bench.inputs.facts.homogeneous);
    const Majorants found = add(bench, true);
    EXPECT_FALSE(found.majorants);
    bench.execute();
    const auto ranges = bench.read<glm::vec2>(found.ranges);
    EXPECT_EQ(ranges[0], glm::vec2(0, 8));
    EXPECT_EQ(ranges[2], glm::vec2(15, 19));
}

TEST_F(MajorantsTest, AreMadeAnewOnlyWhenToldSo) {
    const Volume volume = test::float_volume({24, 9, 9}, [](glm::uvec3 v) { return v.x / 23.0; });
    VolumeBench bench(device(), volume, test::linear_transfer(), {});
    const MajorantsChange changed{
        bench.graph.add_condition("volume_changed"), bench.graph.add_condition("transfer_changed")};
    const Majorants found = add_majorants(
        bench.graph, bench.inputs.facts, bench.inputs.handles, bench.inputs.frame, true, changed);
    bench.graph.export_resource(found.majorants, "compared");
    const auto skipped = [&] {
        std::vector<bool> result;
        for (const PassTime& time : bench.executor().times()) result.push_back(time.skipped);
        return result;
    };
    bench.execute();
    EXPECT_EQ(skipped(), std::vector<bool>(5, false));
    const auto first = bench.read<float>(found.majorants);

    bench.executor().set(changed.volume, false);
    bench.executor().set(changed.transfer, false);
    ASSERT_FALSE(bench.gpu.set_transfer({{{0, 0.25}, {1, 0.5}}}));
    bench.execute();
    EXPECT_EQ(skipped(), std::vector<bool>(5, true));
    EXPECT_EQ(bench.read<float>(found.majorants), first);

    bench.executor().set(changed.transfer, true);
    bench.execute();
    EXPECT_EQ(skipped(), (std::vector{true, false, false, false, false}));
    const auto second = bench.read<float>(found.majorants);
    ASSERT_EQ(second.size(), first.size());
    for (std::size_t i = 0; i < first.size(); ++i)
        EXPECT_NEAR(second[i], 0.25f + 0.25f * first[i], 1e-5f);
}

struct Ray {
    glm::vec3 origin, direction;
    float near = 0, far = 0;
};
struct Walk {
    float reached, farthest, backwards;
    std::uint32_t cells;
};

/// Rays across the unit cube: slanted, along axes and walls, touching edges and corners.
std::vector<Ray> rays_across(std::size_t count) {
    Pcg32 rng(9);
    std::vector<Ray> rays;
    while (rays.size() < count) {
        Ray ray;
        for (int axis = 0; axis < 3; ++axis) {
            ray.origin[axis] = rng.below(3) == 0 ? 0.25f * static_cast<float>(rng.below(5))
                                                 : rng.uniform(-0.5f, 1.5f);
            ray.direction[axis] = rng.below(4) == 0 ? 0.0f : rng.uniform(-1.0f, 1.0f);
        }
        ray.far = 1e30f;
        for (int axis = 0; axis < 3; ++axis) {
            const float d = ray.direction[axis], o = ray.origin[axis];
            if (d == 0) {
                if (o < 0 || o > 1) ray.far = -1;
                continue;
            }
            ray.near = std::max(ray.near, std::min(-o / d, (1 - o) / d));
            ray.far = std::min(ray.far, std::max(-o / d, (1 - o) / d));
        }
        if (ray.far < 1e30f && ray.near < ray.far) rays.push_back(ray);
    }
    return rays;
}

TEST_F(MajorantsTest, WalksVisitEveryCellOnTheirWay) {
    const glm::uvec3 dims(32, 70, 23);
    const Volume volume = test::float_volume(dims, [](glm::uvec3) { return 1; });
    VolumeBench bench(device(), volume, test::linear_transfer(), {});
    const std::vector<Ray> rays = rays_across(20'000);
    const BufferHandle input = bench.buffer("rays", rays);
    PassBuilder pass = bench.graph.add_compute_pass("walk");
    read_medium(pass, bench.inputs, {.light = false, .surfaces = false});
    pass.read("rays", input);
    const BufferHandle output =
        pass.write("walks", bench.graph.create_buffer("walks", {rays.size() * sizeof(Walk)}));
    pass.record([count = static_cast<std::uint32_t>(rays.size())](Commands& commands) {
        commands.dispatch_over({.shader = "test/walk.comp"}, {count, 1, 1});
    });
    bench.graph.export_resource(output, "checked");
    bench.execute();
    const auto walks = bench.read<Walk>(output);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const Ray& ray = rays[i];
        SCOPED_TRACE(fmt::format("from {} {} {} along {} {} {}", ray.origin.x, ray.origin.y,
            ray.origin.z, ray.direction.x, ray.direction.y, ray.direction.z));
        ASSERT_GE(walks[i].reached, ray.far);
        // Rounding may put a place a little outside of the cell, by far less than the half voxel
        // that a cell's bounds reach beyond its walls.
        ASSERT_LT(walks[i].farthest, 1e-3f);
        ASSERT_LE(walks[i].backwards, 1e-5f * ray.far);
        // At most as many as walls between the ends, and the one at the start.
        double walls = 3;
        for (int axis = 0; axis < 3; ++axis)
            walls += double{std::abs(ray.direction[axis])} * double{ray.far - ray.near} *
                     dims[axis] / RANGE_CELL;
        ASSERT_LE(walks[i].cells, walls + 1);
    }
}

} // namespace
} // namespace ockham

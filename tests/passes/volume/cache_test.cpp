// SPDX-License-Identifier: Apache-2.0
// The light cache: which cells it keeps against brute force, what light they hold against closed
// forms, how they are stored, who gets paths, and that it does not matter in how many dispatches.
#include "framework/core/rng.hpp"
#include "shaders/schedule/buckets.h"
#include "tests/support/cache_bench.hpp"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/z_test.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <set>

namespace ockham::test {
namespace {

constexpr double kInverseSphere = 1 / (4 * std::numbers::pi);

double luminance(glm::dvec3 c) { return glm::dot(c, glm::dvec3(0.2126, 0.7152, 0.0722)); }
glm::uvec3 grid_of(const Volume& volume, std::uint32_t scale) {
    return (volume.dims + glm::uvec3(scale - 1)) / glm::uvec3(scale);
}

/// Mostly empty blobs with smooth flanks, in codes of eight bits.
Volume blobs(glm::uvec3 dims, std::uint64_t seed) {
    Pcg32 rng(seed);
    std::vector<glm::dvec4> balls;
    for (int i = 0; i < 6; ++i) {
        const glm::dvec3 place{rng.uniform(), rng.uniform(), rng.uniform()};
        balls.emplace_back(glm::dvec3(dims) * place, 1.5 + 2 * rng.uniform());
    }
    Volume volume;
    volume.name = "blobs";
    volume.dims = dims;
    for (std::uint32_t z = 0; z < dims.z; ++z)
        for (std::uint32_t y = 0; y < dims.y; ++y)
            for (std::uint32_t x = 0; x < dims.x; ++x) {
                double most = 0;
                for (const glm::dvec4& ball : balls)
                    most = std::max(
                        most, 1.5 - glm::distance(glm::dvec3(x, y, z), glm::dvec3(ball)) / ball.w);
                volume.voxels.push_back(static_cast<std::byte>(std::clamp(170 * most, 0.0, 255.0)));
            }
    return volume;
}
/// Opacity from 40 on.
TransferFunction blob_transfer(glm::dvec3 color = glm::dvec3(1.0)) {
    return {{{.value = 40, .opacity = 0, .color = color},
        {.value = 255, .opacity = 1, .color = color}}};
}

/// What the index must be, from the definitions: cells with something to see within half a cell of
/// them, that are not all solid and have a place outside the solid.
std::vector<bool> expected_cells(
    const Volume& volume, const TransferTable& table, const VolumeView& view, std::uint32_t scale) {
    const glm::ivec3 grid(grid_of(volume, scale)), dims(volume.dims);
    const double iso = view.surfaces.empty() ? 1e30 : view.surfaces[0].value;
    std::vector<bool> active;
    for (int i = 0; i < grid.x * grid.y * grid.z; ++i) {
        const glm::ivec3 cell(i % grid.x, i / grid.x % grid.y, i / (grid.x * grid.y));
        const int s = static_cast<int>(scale);
        const glm::dvec3 low(cell * s), high(cell * s + s);
        bool visible = false, open = false, crossing = false;
        // Piece p is the cube between the centres of voxels p - 1 and p.
        for (int z = 0; z <= dims.z; ++z)
            for (int y = 0; y <= dims.y; ++y)
                for (int x = 0; x <= dims.x; ++x) {
                    const glm::dvec3 from = glm::dvec3(x, y, z) - 0.5, to = from + 1.0;
                    const auto meets = [&](double more) {
                        return glm::all(glm::greaterThan(to, low - more)) &&
                               glm::all(glm::lessThan(from, high + more));
                    };
                    if (!meets(0.5 * s)) continue;
                    double least = 1e30, greatest = -1e30;
                    for (int c = 0; c < 8; ++c) {
                        const double value =
                            volume.at(glm::ivec3(x - (c & 1), y - (c >> 1 & 1), z - (c >> 2)));
                        least = std::min(least, value);
                        greatest = std::max(greatest, value);
                    }
                    const glm::dvec3 size(volume.dims);
                    const bool kept =
                        glm::all(glm::greaterThan(to / size, glm::dvec3(view.crop_min))) &&
                        glm::all(glm::lessThan(from / size, glm::dvec3(view.crop_max)));
                    visible = visible || (kept && table.max_opacity(least, greatest) > 0);
                    open = open || (meets(0) && least < iso);
                    crossing = crossing || (least < iso && greatest >= iso);
                }
        bool place = !crossing;
        const glm::dvec3 size(volume.dims);
        const glm::dvec3 first =
            glm::clamp(low / size, glm::dvec3(view.crop_min), glm::dvec3(view.crop_max));
        const glm::dvec3 last =
            glm::clamp(high / size, glm::dvec3(view.crop_min), glm::dvec3(view.crop_max));
        for (int p = 0; p < 64 && !place; ++p)
            place = volume.sample(glm::mix(
                        first, last, glm::dvec3(p & 3, p >> 2 & 3, p >> 4) * 0.25 + 0.125)) < iso;
        active.push_back(visible && open && place);
    }
    return active;
}

/// Mean radiance that an environment of 1 sends through a homogeneous absorbing unit cube to the
/// points of a box, by quadrature.
double absorbed_mean(glm::dvec3 low, glm::dvec3 high, double sigma, int points) {
    double sum = 0;
    constexpr int kDirections = 2000;
    for (int p = 0; p < points * points * points; ++p) {
        const glm::dvec3 place =
            (glm::dvec3(p % points, p / points % points, p / (points * points)) + 0.5) /
            static_cast<double>(points);
        const glm::dvec3 o = glm::mix(low, high, place);
        for (int i = 0; i < kDirections; ++i) { // a Fibonacci lattice
            const double z = 1 - (2 * i + 1.0) / kDirections, phi = (i + 0.5) * 2.399963229728653;
            const glm::dvec3 d(
                std::sqrt(1 - z * z) * std::cos(phi), std::sqrt(1 - z * z) * std::sin(phi), z);
            double t = 1e30;
            for (int a = 0; a < 3; ++a) t = std::min(t, ((d[a] > 0 ? 1.0 : 0.0) - o[a]) / d[a]);
            sum += std::exp(-sigma * t);
        }
    }
    return sum / (kDirections * points * points * points);
}

class CacheTest : public GpuTest {
protected:
    static void expect_active(const Volume& volume, const VolumeView& view, std::uint32_t scale) {
        SCOPED_TRACE(testing::Message() << "scale " << scale);
        CacheBench bench(
            device(), volume, blob_transfer(), view, {.scale = scale, .working_set = 64});
        bench.execute();
        const std::vector<bool> expected =
            expected_cells(volume, bench.bench.gpu.table(), view, scale);
        const std::vector<CachedCell> cells = bench.cells();
        ASSERT_EQ(cells.size(), expected.size());
        std::uint32_t slots = 0;
        for (std::size_t i = 0; i < cells.size(); ++i) {
            ASSERT_EQ(cells[i].word != CACHE_NONE, expected[i]) << "cell " << i;
            if (!expected[i]) continue;
            ASSERT_EQ(cells[i].word & CACHE_SLOT_MASK, slots++) << "cell " << i;
        }
        EXPECT_EQ(bench.size.slots, slots);
        EXPECT_EQ(bench.size.cells, cells.size());
        EXPECT_GT(slots, 0u);
        EXPECT_LT(slots, cells.size());
    }

    /// Each stored value is finite and not negative; how many there are.
    static std::size_t expect_sound(const std::vector<CachedCell>& cells) {
        std::size_t values = 0;
        for (const CachedCell& cell : cells) {
            if (!cell.phi) continue;
            ++values;
            for (int c = 0; c < 3; ++c) EXPECT_TRUE((*cell.phi)[c] >= 0 && (*cell.phi)[c] < 1e6);
            EXPECT_LE(glm::length(cell.flow), 1.001);
        }
        return values;
    }

    static VolumeView dim_view(float density) {
        VolumeView view;
        view.density_scale = density;
        return view;
    }
};

TEST_F(CacheTest, ActiveCellsEqualABruteForce) {
    const Volume volume = blobs({19, 13, 34}, 5);
    for (const std::uint32_t scale : {1u, 2u, 4u}) expect_active(volume, {}, scale);
}

TEST_F(CacheTest, CellsInsideTheSurfaceOrBeyondTheCropAreLeftOut) {
    const Volume volume = blobs({17, 18, 19}, 6);
    VolumeView view;
    view.surfaces = {{.value = 120.5}};
    view.crop_min = {0.2f, 0.0f, 0.1f};
    view.crop_max = {1.0f, 0.7f, 0.9f};
    for (const std::uint32_t scale : {1u, 2u, 4u}) expect_active(volume, view, scale);
}

TEST_F(CacheTest, CellsOfTheSolidMayHoldMemory) {
    const Volume volume = blobs({17, 18, 19}, 6);
    VolumeView view;
    view.surfaces = {{.value = 120.5}};
    CacheBench without(device(), volume, blob_transfer(), view, {});
    CacheBench with(device(), volume, blob_transfer(), view, {.hold_solid = true});
    EXPECT_EQ(without.size.solid, 0u);
    EXPECT_GT(with.size.solid, 0u);
    EXPECT_EQ(with.size.slots, without.size.slots + with.size.solid);
    with.execute();
    EXPECT_EQ(with.control().cells, without.size.slots);
}

TEST_F(CacheTest, AWhiteFurnaceIsOneInEveryCell) {
    const Volume volume = blobs({12, 9, 10}, 7);
    for (const CacheFormat format : {CacheFormat::fp32, CacheFormat::fp16, CacheFormat::rgb9e5}) {
        for (const std::uint32_t scale : {1u, 2u, 4u}) {
            for (const float g : {0.0f, 0.7f}) {
                VolumeView view = dim_view(20);
                view.phase_g = g;
                CacheBench bench(device(), volume, blob_transfer(), view,
                    {.scale = scale, .format = format, .directional = g != 0, .paths = 256});
                bench.execute();
                const std::vector<CachedCell> cells = bench.cells();
                EXPECT_EQ(expect_sound(cells), bench.size.slots);
                double z_most = 0;
                for (const CachedCell& cell : cells) {
                    if (!cell.phi) continue;
                    for (int c = 0; c < 3; ++c) EXPECT_NEAR((*cell.phi)[c], 1, 1e-5);
                    // Directions of the paths are uniform: each component has variance 1 / 3.
                    for (int c = 0; c < 3; ++c)
                        z_most = std::max(z_most, std::abs(cell.flow[c]) / std::sqrt(1.0 / 3 / 32));
                }
                EXPECT_LT(z_most, z_limit(3 * std::size_t{bench.size.slots}));
                EXPECT_EQ(bench.control().clamped, 0u);
            }
        }
    }
}

TEST_F(CacheTest, AnAbsorbingCubeIsLitAsByQuadrature) {
    EXPECT_NEAR(absorbed_mean(glm::dvec3(0.5), glm::dvec3(0.5), 4, 1), 0.09086, 2e-5);
    EXPECT_NEAR(absorbed_mean(glm::dvec3(1.0 / 16), glm::dvec3(1.0 / 16), 4, 1), 0.54086, 5e-4);
    const Volume volume = float_volume({8, 8, 8}, [](glm::uvec3) { return 1.0; });
    VolumeView view = dim_view(4);
    view.albedo = 0;
    CacheBench bench(device(), volume, linear_transfer(), view,
        {.scale = 1, .format = CacheFormat::fp32, .target_error = 0, .paths = 256});
    bench.execute(7);
    // Each path gives 0 or 1. Cells that differ by a symmetry of the cube have one expectation.
    std::vector<std::pair<double, double>> classes(64);
    const std::vector<CachedCell> cells = bench.cells();
    const std::vector<shader::CacheSum> sums = bench.sums();
    for (std::size_t i = 0; i < cells.size(); ++i) { // slots are in the order of the grid
        std::size_t at[3] = {i % 8, i / 8 % 8, i / 64};
        for (std::size_t& a : at) a = std::min(a, 7 - a);
        std::sort(std::begin(at), std::end(at));
        auto& [sum, paths] = classes[at[0] * 16 + at[1] * 4 + at[2]];
        ASSERT_TRUE(cells[i].phi);
        ASSERT_GE(sums[i].count, 1000u);
        sum += cells[i].phi->x * sums[i].count;
        paths += sums[i].count;
    }
    for (std::size_t k = 0; k < 64; ++k) {
        const auto [sum, paths] = classes[k];
        if (paths == 0) continue;
        const glm::dvec3 low = glm::dvec3(k / 16, k / 4 % 4, k % 4) / 8.0;
        const double truth = absorbed_mean(low, low + 0.125, 4, 4);
        const Estimate found{sum / paths, std::sqrt(truth * (1 - truth) / paths)};
        EXPECT_LT(z_of(found, truth), z_limit(20)) << k << ": " << found.mean << " " << truth;
    }
}

TEST_F(CacheTest, LightComesStraightByTheExponentialAndFromItsSide) {
    const Volume volume = float_volume({8, 8, 16}, [](glm::uvec3) { return 1.0; });
    VolumeView view = dim_view(2);
    view.environment = glm::vec3(0.0f);
    view.light_direction = {0, 0, 1};
    view.light_irradiance = {3, 2, 1};
    view.phase_g = 0.5f;
    view.max_bounces = 1;
    CacheBench bench(device(), volume, linear_transfer(), view,
        {.scale = 2,
            .format = CacheFormat::fp32,
            .directional = true,
            .target_error = 0,
            .paths = 256});
    bench.execute(10);
    const std::vector<CachedCell> cells = bench.cells();
    ASSERT_EQ(cells.size(), 128u);
    const std::vector<shader::CacheSum> sums = bench.sums();
    for (std::size_t layer = 0; layer < 8; ++layer) {
        double mean = 0, square = 0, paths = 0;
        for (std::size_t i = layer * 16; i < layer * 16 + 16; ++i) {
            ASSERT_TRUE(cells[i].phi);
            ASSERT_GE(sums[i].count, 1000u);
            mean += cells[i].phi->y * sums[i].count;
            square += 4 * sums[i].square / std::pow(luminance({3, 2, 1}), 2);
            paths += sums[i].count;
            if (cells[i].phi->y > 0) {
                EXPECT_NEAR(cells[i].phi->x, 1.5 * cells[i].phi->y, 1e-5);
                EXPECT_NEAR(glm::distance(cells[i].flow, glm::dvec3(0, 0, -1)), 0, 1e-3);
            }
        }
        mean /= paths;
        const double h = 1.0 / 8, tau = 2 * h;
        const double truth = kInverseSphere * 2 * std::exp(-2 * h * static_cast<double>(layer)) *
                             (1 - std::exp(-tau)) / tau;
        const double variance = (square / paths - mean * mean) / paths;
        EXPECT_LT(z_of(Estimate{mean, std::sqrt(variance)}, truth), z_limit(8))
            << mean << " " << truth;
    }
}

TEST_F(CacheTest, WhatAClipPlaneCutsAwayKeepsNoLightOut) {
    // Lit from the side that is cut away: layers 0 and 1, and half of layer 2.
    const Volume volume = float_volume({8, 8, 16}, [](glm::uvec3) { return 1.0; });
    VolumeView view = dim_view(2);
    view.environment = glm::vec3(0.0f);
    view.light_direction = {0, 0, 1};
    view.light_irradiance = glm::vec3(1.0f);
    view.max_bounces = 1;
    const double h = 1.0 / 8, bottom = -0.5 + 2.5 * h;
    view.clip_planes = {glm::vec4(0.0f, 0.0f, 1.0f, -bottom)};
    CacheBench bench(device(), volume, linear_transfer(), view,
        {.scale = 2, .format = CacheFormat::fp32, .target_error = 0, .paths = 256});
    bench.execute(4);
    const std::vector<CachedCell> cells = bench.cells();
    const std::vector<shader::CacheSum> sums = bench.sums();
    ASSERT_EQ(cells.size(), 128u);
    for (std::size_t layer = 0; layer < 8; ++layer) {
        const double low = std::max(-0.5 + h * static_cast<double>(layer), bottom);
        const double high = -0.5 + h * static_cast<double>(layer + 1);
        double mean = 0, variance = 0;
        for (std::size_t i = layer * 16; i < layer * 16 + 16; ++i) {
            const CachedCell& cell = cells[i];
            ASSERT_EQ((cell.word & CACHE_NEAR) != 0 && cell.word != CACHE_NONE, layer == 2) << i;
            ASSERT_EQ(cell.phi.has_value(), layer >= 2) << i;
            if (!cell.phi) continue;
            const shader::CacheSum& sum = sums[cell.word & CACHE_SLOT_MASK];
            mean += cell.phi->x / 16;
            variance +=
                (double{sum.square} / sum.count - std::pow(cell.phi->x, 2)) / sum.count / 256;
        }
        if (layer < 2) continue;
        const double from = 2 * (low - bottom), to = 2 * (high - bottom);
        const double truth = kInverseSphere * (std::exp(-from) - std::exp(-to)) / (to - from);
        EXPECT_LT(z_of(Estimate{mean, std::sqrt(variance)}, truth), z_limit(6)) << layer;
    }
}

/// Fog with an opaque ball in its middle, lit along +x.
constexpr double kBall = 7.0; // voxels
Volume ball_in_fog() {
    return float_volume({24, 24, 24}, [](glm::uvec3 voxel) {
        const double r = glm::distance(glm::dvec3(voxel) + 0.5, glm::dvec3(12.0));
        return std::clamp(0.5 + 0.25 * (kBall - r), 0.1, 1.0);
    });
}
VolumeView beam_view() {
    VolumeView view;
    view.density_scale = 5;
    view.environment = glm::vec3(0.0f);
    view.light_direction = {1, 0, 0};
    view.light_irradiance = glm::vec3(1.0f);
    view.max_bounces = 1;
    view.surfaces = {{.value = 0.5}};
    return view;
}

TEST_F(CacheTest, TheUmbraOfABallIsDark) {
    const Volume volume = ball_in_fog();
    for (const std::uint32_t scale : {1u, 2u, 4u}) {
        CacheBench bench(
            device(), volume, linear_transfer(), beam_view(), {.scale = scale, .paths = 128});
        bench.execute();
        const std::vector<CachedCell> cells = bench.cells();
        expect_sound(cells);
        const glm::ivec3 grid(grid_of(volume, scale));
        std::size_t dark = 0, lit = 0;
        for (int i = 0; i < static_cast<int>(cells.size()); ++i) {
            if (!cells[static_cast<std::size_t>(i)].phi) continue;
            const double value = cells[static_cast<std::size_t>(i)].phi->x;
            const glm::dvec3 low =
                glm::dvec3(i % grid.x, i / grid.x % grid.y, i / (grid.x * grid.y)) *
                static_cast<double>(scale);
            // Distances from the axis, nearest and farthest.
            const glm::dvec2 from = glm::abs(glm::dvec2(low.y, low.z) + 0.5 * scale - 12.0);
            const double farthest = glm::length(from + 0.5 * scale);
            const double nearest = glm::length(glm::max(from - 0.5 * scale, glm::dvec2(0.0)));
            if (low.x >= 12 && farthest < kBall - 0.5) {
                EXPECT_EQ(value, 0) << "cell " << i;
                ++dark;
            } else if (low.x + scale <= 12 - kBall - 0.5 || nearest > kBall + 0.5) {
                EXPECT_GT(value, 0) << "cell " << i;
                ++lit;
            }
        }
        EXPECT_GT(dark, 2u);
        EXPECT_GT(lit, 50u);
    }
}

TEST_F(CacheTest, NoLightLeaksThroughAWallOneVoxelThick) {
    // Columns 8 to 11 make one cell at scale 4, and the wall divides it.
    for (const std::uint32_t wall : {8u, 9u, 10u, 11u}) {
        const Volume volume = float_volume(
            {16, 16, 16}, [wall](glm::uvec3 voxel) { return voxel.x == wall ? 1.0 : 0.1; });
        std::vector<glm::vec3> places;
        std::vector<bool> behind;
        for (float x = 0.25f; x < 16; x += 0.5f) {
            if (std::abs(x - static_cast<float>(wall) - 0.5f) < 0.6f) continue;
            for (float y = 2.25f; y < 14; y += 2.5f) {
                places.emplace_back(x / 16, y / 16, 0.5f);
                places.emplace_back(0.0f, 1.0f, 0.0f);
                behind.push_back(x > static_cast<float>(wall));
            }
        }
        CacheBench bench(
            device(), volume, linear_transfer(), beam_view(), {.scale = 4, .paths = 256}, places);
        bench.execute();
        const std::vector<glm::vec3> light = bench.light();
        ASSERT_EQ(light.size(), behind.size());
        for (std::size_t i = 0; i < light.size(); ++i) {
            SCOPED_TRACE(testing::Message() << "wall " << wall << ", x = " << places[2 * i].x * 16);
            EXPECT_EQ(light[i].x == 0, behind[i]) << light[i].x;
        }
    }
}

TEST_F(CacheTest, PointsInATranslucentSheetSeeTheLightAroundIt) {
    // No cell has its point in the sheet, and each is seen through one of its faces.
    const Volume volume =
        float_volume({16, 16, 16}, [](glm::uvec3 voxel) { return voxel.x == 9 ? 1.0 : 0.1; });
    VolumeView view = dim_view(5);
    view.surfaces = {{.value = 0.5, .opacity = 0.5f}};
    std::vector<glm::vec3> places;
    for (float y = 0.1f; y < 1; y += 0.1f) {
        places.emplace_back(9.5f / 16, y, 0.5f);
        places.emplace_back(0.0f, 1.0f, 0.0f);
    }
    CacheBench bench(device(), volume, linear_transfer(), view, {.paths = 32}, places);
    bench.execute();
    for (const glm::vec3& light : bench.light()) EXPECT_GT(light.x, 0.3f); // black from one side
}

TEST_F(CacheTest, ReadersGetHarmonicsOfOrderOne) {
    const Volume volume = float_volume({8, 8, 8}, [](glm::uvec3) { return 1.0; });
    VolumeView view = dim_view(1e-3f);
    view.environment = glm::vec3(0.0f);
    view.light_direction = {0, 0, 1};
    view.light_irradiance = {3, 2, 1};
    view.phase_g = 0.3f;
    view.max_bounces = 1;
    std::vector<glm::vec3> places;
    for (const glm::vec3 direction :
        {glm::vec3(0, 0, 1), {0, 0, -1}, {1, 0, 0}, {0, 0.6f, -0.8f}}) {
        places.emplace_back(0.41f, 0.52f, 0.63f);
        places.push_back(direction);
    }
    CacheBench bench(device(), volume, linear_transfer(), view,
        {.format = CacheFormat::fp32, .directional = true, .paths = 8}, places);
    bench.execute();
    const std::vector<glm::vec3> light = bench.light();
    for (std::size_t i = 0; i < light.size(); ++i) {
        // Light travels along +z; what scatters towards the eye goes against the ray.
        const double expected = std::max(0.0, 1 + 3 * 0.3 * -places[2 * i + 1].z) * kInverseSphere;
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(light[i][c], (3 - c) * expected, 1e-3 * (3 - c));
    }
}

TEST_F(CacheTest, FormatsRoundOnceAndNeverDrift) {
    // Each path gives 0 or 1: a running mean in halves would go astray.
    const Volume volume = float_volume({4, 4, 4}, [](glm::uvec3) { return 1.0; });
    VolumeView view = dim_view(8);
    view.albedo = 0;
    view.environment = {1.0f, 0.3f, 0.01f};
    constexpr std::uint32_t kPaths = 32768;
    std::vector<CachedCell> exact;
    for (const CacheFormat format : {CacheFormat::fp32, CacheFormat::fp16, CacheFormat::rgb9e5}) {
        CacheBench bench(device(), volume, linear_transfer(), view,
            {.scale = 2, .format = format, .target_error = 0, .paths = 1024});
        bench.execute(120);
        const std::vector<CachedCell> cells = bench.cells();
        const std::vector<shader::CacheSum> sums = bench.sums();
        for (std::size_t i = 0; i < 8; ++i) ASSERT_GE(sums[i].count, kPaths);
        if (format == CacheFormat::fp32) {
            exact = cells;
            const double truth = absorbed_mean(glm::dvec3(0.0), glm::dvec3(0.5), 8, 16);
            for (const CachedCell& cell : cells) {
                const Estimate found{cell.phi->x, std::sqrt(truth * (1 - truth) / kPaths)};
                EXPECT_LT(z_of(found, truth), z_limit(8)) << found.mean << " " << truth;
            }
        }
        for (std::size_t i = 0; i < cells.size(); ++i) {
            for (int c = 0; c < 3; ++c) {
                const double value = (*exact[i].phi)[c];
                int exponent = 0;
                std::frexp(format == CacheFormat::rgb9e5 ? exact[i].phi->x : value, &exponent);
                const double half_ulp = format == CacheFormat::fp32 ? 0
                                        : format == CacheFormat::fp16
                                            ? std::ldexp(1.0, std::max(exponent, -13) - 12)
                                            : std::ldexp(1.0, exponent - 10);
                EXPECT_LE(std::abs((*cells[i].phi)[c] - value), half_ulp);
            }
        }
    }
}

/// What cache_allocate.comp promises, from the sums before it: the bucket, and the paths that the
/// mean will be of, 0 where these are not known yet.
struct Order {
    std::uint32_t bucket, due;
};
Order expected_order(const shader::CacheSum& sum, double goal, double light) {
    const auto bucket_of = [](std::uint32_t paths) {
        return 1 + static_cast<std::uint32_t>(std::bit_width(std::bit_ceil(paths)));
    };
    if (sum.cell == CACHE_NONE) return {1, 0};
    std::uint32_t count = sum.count, due = sum.due, most = due;
    double need = due;
    if (due == 0) {
        if (count < CACHE_TRUST_PATHS) // as many again, up to 8
            return {bucket_of(std::clamp(count, 1u, 8u)), 0};
        const double n = count, mean = luminance(glm::dvec3(sum.radiance)) / n;
        const double spread = std::max(sum.square - n * mean * mean, 0.0) + light * light;
        need = spread / (n - 1) / std::pow(goal * std::max(mean, 0.05 * light), 2);
        most = 2 * std::bit_floor(count);
        if (std::has_single_bit(count) && need <= CACHE_TRUST_TIMES * n) {
            most = due = std::max(static_cast<std::uint32_t>(std::ceil(need)), count);
            count = 0;
        }
    }
    if (count >= most) return {1, due};
    const double urgency = need / std::max(count, 1u) * sum.contribution;
    const std::uint32_t paths = urgency >= 16 ? 8 : urgency >= 4 ? 4 : urgency >= 1 ? 2 : 1;
    return {bucket_of(std::min(paths, most - count)), due};
}

TEST_F(CacheTest, PathsGoWhereVarianceAndContributionAre) {
    const Volume volume = blobs({18, 16, 14}, 8);
    VolumeView view = dim_view(30);
    view.albedo = 0.7f;
    CacheBench bench(device(), volume, blob_transfer(), view, {.target_error = 0.04f});
    std::set<std::uint32_t> seen;
    std::uint64_t paths = 0, done = 0;
    for (int step = 0; step < 48; ++step) {
        std::vector<shader::CacheSum> before;
        if (step > 0) before = bench.sums();
        bench.execute();
        if (step == 0) continue;
        const std::vector<std::uint8_t> counts = bench.counts();
        ASSERT_EQ(counts.size() % CACHE_SET_WIDTH, 0u);
        const std::vector<shader::CacheSum> sums = bench.sums();
        std::uint64_t ordered = 0;
        done = 0;
        for (std::size_t i = 0; i < counts.size(); ++i) {
            ASSERT_TRUE(counts[i] >= 1 && counts[i] <= 5);
            seen.insert(counts[i]);
            if (i >= before.size()) {
                ASSERT_EQ(counts[i], 1u);
                continue;
            }
            // Rounding may move a cell across a bound: both sides of it are right there.
            const Order lower = expected_order(before[i], 0.04 * 1.001, 1);
            const Order upper = expected_order(before[i], 0.04 * 0.999, 1);
            ASSERT_TRUE(counts[i] >= std::min(lower.bucket, upper.bucket) &&
                        counts[i] <= std::max(lower.bucket, upper.bucket))
                << "step " << step << ", slot " << i;
            const shader::CacheSum after = sums[i];
            ASSERT_TRUE(after.due >= std::min(lower.due, upper.due) &&
                        after.due <= std::max(lower.due, upper.due));
            // Those that judge are left out of the mean.
            const bool judged = after.due > 0 && before[i].due == 0;
            if (judged) {
                ASSERT_EQ(after.least, before[i].count);
            }
            const std::uint32_t got = after.count - (judged ? 0 : before[i].count);
            ASSERT_LE(got, counts[i] == 1 ? 0u : 1u << (counts[i] - 2));
            ASSERT_TRUE(after.due == 0 || after.count <= after.due);
            done += after.due > 0 && after.count == after.due ? 1 : 0;
            ordered += got;
        }
        const shader::CacheControl control = bench.control();
        if (step > 1) {
            ASSERT_EQ(control.paths.x - paths, ordered);
        }
        paths = control.paths.x;
    }
    EXPECT_EQ(seen.size(), 5u);
    EXPECT_GT(done, 0u);
    EXPECT_EQ(bench.control().steps, 48u);
}

/// A scene with everything that interrupts and divides: surface, scattering, both kinds of light.
VolumeView mixed_view() {
    VolumeView view = beam_view();
    view.environment = glm::vec3(0.3f);
    view.max_bounces = ~0u;
    view.albedo = 0.8f;
    view.phase_g = 0.4f;
    return view;
}
Volume small_ball() {
    return float_volume({12, 12, 12}, [](glm::uvec3 voxel) {
        return std::clamp(
            0.5 + 0.25 * (2.5 - glm::distance(glm::dvec3(voxel), glm::dvec3(5.3))), 0.1, 1.0);
    });
}

TEST_F(CacheTest, TheLoopBudgetAndTheBlocksChangeNothing) {
    const Volume volume = small_ball();
    const CacheParams params{.directional = true, .target_error = 0.15f, .paths = 16};
    CacheBench whole(device(), volume, linear_transfer(), mixed_view(), params);
    ASSERT_TRUE(whole.converge(200));
    EXPECT_EQ(expect_sound(whole.cells()), whole.size.slots);
    EXPECT_EQ(whole.control().resumed.x, 0u);

    CacheParams interrupted = params;
    interrupted.iterations = 64;
    CacheBench pieces(device(), volume, linear_transfer(), mixed_view(), interrupted);
    ASSERT_TRUE(pieces.converge(2000));
    EXPECT_GT(pieces.control().resumed.x, 0u);
    EXPECT_EQ(pieces.control().paths.x, whole.control().paths.x);
    EXPECT_EQ(pieces.words(pieces.cache.cells), whole.words(whole.cache.cells));

    // Few places for those that are interrupted: most begin anew, and lose nothing but time.
    interrupted.iterations = 300;
    interrupted.places = 8;
    CacheBench crowded(device(), volume, linear_transfer(), mixed_view(), interrupted);
    ASSERT_TRUE(crowded.converge(2000));
    EXPECT_GT(crowded.control().resumed.x, 0u);
    EXPECT_EQ(crowded.control().paths.x, whole.control().paths.x);
    EXPECT_EQ(crowded.words(crowded.cache.cells), whole.words(whole.cache.cells));

    CacheParams blocks = params;
    blocks.working_set = 64;
    CacheBench divided(device(), volume, linear_transfer(), mixed_view(), blocks);
    ASSERT_TRUE(divided.converge(2000));
    EXPECT_GT(divided.control().blocks, 1u);
    EXPECT_GT(divided.control().round, 0u);
    EXPECT_EQ(divided.words(divided.cache.cells), whole.words(whole.cache.cells));
}

TEST_F(CacheTest, AfterAChangeTheCacheIsAFreshOne) {
    const Volume volume = small_ball();
    const CacheParams params{.hold_solid = true, .paths = 32};
    const auto changed = [](auto edit) {
        VolumeView view = mixed_view();
        edit(view);
        return view;
    };
    const std::tuple<const char*, VolumeView, CacheChange> cases[] = {
        {"light", changed([](VolumeView& v) {
             v.light_irradiance = {0, 2, 1};
         }),
            CacheChange::light},
        {"environment", changed([](VolumeView& v) {
             v.environment = {1, 0, 1};
         }),
            CacheChange::light},
        {"density", changed([](VolumeView& v) { v.density_scale = 9; }), CacheChange::light},
        {"g", changed([](VolumeView& v) { v.phase_g = -0.5f; }), CacheChange::light},
        {"albedo", changed([](VolumeView& v) { v.albedo = 0.2f; }), CacheChange::light},
        {"isovalue", changed([](VolumeView& v) { v.surfaces[0].value = 0.8; }),
            CacheChange::surface},
        {"crop", changed([](VolumeView& v) { v.crop_max.x = 0.6f; }), CacheChange::medium},
    };
    CacheBench used(device(), volume, linear_transfer(), mixed_view(), params);
    used.execute(2);
    for (const auto& [name, view, change] : cases) {
        SCOPED_TRACE(name);
        const std::vector<std::uint32_t> before = used.words(used.cache.cells);
        used.set_view(view);
        used.change(change);
        used.execute(2);
        CacheBench fresh(device(), volume, linear_transfer(), view, params);
        fresh.execute(2);
        EXPECT_NE(used.words(used.cache.cells), before);
        EXPECT_EQ(used.words(used.cache.index), fresh.words(fresh.cache.index));
        const std::vector<CachedCell> a = used.cells(), b = fresh.cells();
        for (std::size_t i = 0; i < a.size(); ++i) {
            const bool solid = (b[i].word & CACHE_NEAR) == 0 &&
                               b[i].word >> CACHE_PLACE_SHIFT == CACHE_PLACE_SOLID;
            if (solid) continue;
            ASSERT_EQ(a[i].phi, b[i].phi) << "cell " << i;
        }
        ASSERT_EQ(used.control().paths, fresh.control().paths);
    }
}

TEST_F(CacheTest, ACameraMoveGoesOn) {
    CacheBench bench(device(), small_ball(), linear_transfer(), mixed_view(), {.target_error = 0});
    bench.execute(2);
    const std::uint32_t paths = bench.control().paths.x;
    bench.change(CacheChange::none);
    bench.execute(2);
    EXPECT_EQ(bench.control().steps, 4u);
    EXPECT_EQ(bench.control().paths.x, 4 * paths); // 1 + 1 + 2 + 4 against 1 + 1
}

TEST_F(CacheTest, CellsShowTheirOldValueUntilEightPathsHaveEnded) {
    VolumeView view = mixed_view();
    CacheBench bench(
        device(), small_ball(), linear_transfer(), view, {.hold_solid = true, .iterations = 100});
    bench.execute(80);
    const std::vector<CachedCell> before = bench.cells();
    view.surfaces[0].value = 0.6;
    bench.set_view(view);
    bench.change(CacheChange::surface);
    std::size_t old_shown = 0, new_shown = 0;
    for (int step = 0; step < 40; ++step) {
        bench.execute();
        const std::vector<CachedCell> after = bench.cells();
        const std::vector<shader::CacheSum> sums = bench.sums();
        for (const shader::CacheSum& sum : sums) {
            if (sum.cell == CACHE_NONE || sum.due > 0) continue;
            const CachedCell& cell = after[sum.cell];
            if (sum.count < CACHE_REPLACE_PATHS) {
                if (!before[sum.cell].phi) continue; // better few paths than none
                EXPECT_EQ(cell.phi, before[sum.cell].phi);
                ++old_shown;
            } else {
                ASSERT_TRUE(cell.phi);
                EXPECT_NEAR(luminance(*cell.phi), luminance(glm::dvec3(sum.radiance)) / sum.count,
                    1e-3 * luminance(*cell.phi));
                ++new_shown;
            }
        }
    }
    EXPECT_GT(old_shown, 0u);
    EXPECT_GT(new_shown, 0u);
}

TEST_F(CacheTest, AnEmptyVolumeHasNoCells) {
    const Volume volume = float_volume({9, 9, 9}, [](glm::uvec3) { return 0.0; });
    CacheBench bench(device(), volume, linear_transfer(), {}, {});
    EXPECT_EQ(bench.size.slots, 0u);
    EXPECT_TRUE(bench.converge(2));
    EXPECT_EQ(bench.control().paths.x, 0u);
}

TEST_F(CacheTest, WhatCannotBeIsRefusedByName) {
    const Volume volume = float_volume({8, 8, 8}, [](glm::uvec3) { return 1.0; });
    const auto refusal = [&](const CacheParams& params) {
        return error_of([&] { CacheBench(device(), volume, linear_transfer(), {}, params); });
    };
    EXPECT_NE(refusal({.scale = 3}).find("scale 3"), std::string::npos);
    EXPECT_NE(refusal({.paths = 12}).find("12 paths"), std::string::npos);
    EXPECT_NE(refusal({.target_error = -1}).find("target error -1"), std::string::npos);
    EXPECT_NE(refusal({.working_set = 1}).find("working set of 1 "), std::string::npos);
}

TEST_F(CacheTest, WorkingSetsThatTheDeviceCannotBindAreRefusedWithNumbers) {
    const Volume large = float_volume({192, 128, 128}, [](glm::uvec3) { return 1.0; });
    const std::string text = error_of([&] {
        CacheBench(device(), large, linear_transfer(), {}, {.scale = 1, .working_set = 1u << 22});
    });
    EXPECT_NE(text.find("working set of 3145728 cells takes 168.0 MiB"), std::string::npos) << text;
}

TEST_F(CacheTest, MarksThatTheDeviceCannotBindAreRefusedWithNumbers) {
    Volume flat; // so that of all the cache needs only these are too many
    flat.name = "flat";
    flat.dims = {1, 3400, 3400};
    flat.voxels.resize(flat.voxel_count());
    const VolumeGpu large(device(), flat, linear_transfer());
    const gpu::Buffer frame(device(), {.bytes = sizeof(shader::VolumeFrame),
                                          .usage = VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT,
                                          .name = "frame"});
    const std::string text =
        error_of([&] { count_cache_cells(device(), large, frame, {.scale = 4}); });
    EXPECT_NE(text.find("1 x 3400 x 3400 voxels takes 132.4 MiB"), std::string::npos) << text;
}

} // namespace
} // namespace ockham::test

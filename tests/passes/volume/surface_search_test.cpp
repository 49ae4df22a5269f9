// SPDX-License-Identifier: Apache-2.0
// find_surface() of shaders/volume/surface.glsl against a brute-force search in double precision,
// on fields whose isosurfaces are as bad as they get, for any direction, start and loop budget.
#include "framework/core/rng.hpp"
#include "framework/runtime/commands.hpp"
#include "tests/passes/volume/shaders/test/find_surface.h"
#include "tests/reference/trilinear_surface.hpp"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/volume_bench.hpp"

#include <bit>
#include <functional>

namespace ockham::test {
namespace {

using Ray = shader::FindSurfaceRay;
using Hit = shader::FindSurfaceHit;

/// A volume of floats with isovalues, on the device and for the twin.
class Scene {
public:
    Scene(gpu::Device& device, Volume volume, const std::vector<double>& isovalues)
        : device_(device), volume_(std::move(volume)), place(place_of(volume_)) {
        for (const double value : isovalues) view_.surfaces.push_back({.value = value});
        field.dims = glm::ivec3(volume_.dims);
        field.voxels.resize(volume_.voxel_count());
        std::memcpy(field.voxels.data(), volume_.voxels.data(), volume_.voxels.size());
    }

    std::vector<Hit> find(const std::vector<Ray>& rays, std::uint32_t budget = 40000) {
        VolumeBench bench(device_, volume_, linear_transfer(), {.view = view_});
        values.clear();
        for (std::uint32_t i = 0; i < bench.frame.surface_count; ++i)
            values.push_back(double{bench.frame.surfaces[i].value});
        BufferHandle hits = bench.graph.create_buffer("hits", {rays.size() * sizeof(Hit)});
        const BufferHandle given = bench.buffer("rays", rays);
        PassBuilder pass = bench.graph.add_compute_pass("find_surface");
        read_medium(pass, bench.inputs, {.tracking = false, .light = false});
        pass.read("rays", given);
        hits = pass.write("hits", hits);
        const auto count = static_cast<std::uint32_t>(rays.size());
        pass.record([count, budget](Commands& commands) {
            const shader::FindSurfacePush push{count, budget};
            commands.dispatch_over(
                {.shader = "test/find_surface.comp:surfaces", .push = as_push(push)},
                {count, 1, 1});
        });
        bench.graph.export_resource(hits, "test");
        bench.execute();
        return bench.read<Hit>(hits);
    }

    /// The part of o + t d in the box, from t = 0 on, a little inside; a ray of no length if none.
    Ray ray(glm::dvec3 origin, glm::dvec3 direction, bool start_solid = true) const {
        Ray out{.origin = origin,
            .t0 = 0,
            .direction = direction,
            .t1 = 0,
            .entry_normal = {},
            .start_solid = start_solid};
        const glm::dmat3 inverse = glm::inverse(place.edges);
        const glm::dvec3 o = inverse * (glm::dvec3(out.origin) - place.corner);
        const glm::dvec3 d = inverse * glm::dvec3(out.direction);
        double near = 0, far = 1e9;
        for (int axis = 0; axis < 3; ++axis) {
            if (d[axis] == 0) {
                if (o[axis] < 0 || o[axis] > 1) return out;
                continue;
            }
            const double a = -o[axis] / d[axis], b = (1 - o[axis]) / d[axis];
            near = std::max(near, std::min(a, b));
            far = std::min(far, std::max(a, b));
        }
        if (near >= far) return out;
        out.t0 = static_cast<float>(near);
        out.t1 = static_cast<float>(far);
        return out;
    }

    /// In units of voxels: world length of the smallest side.
    double voxel() const {
        double side = 1e9;
        for (int axis = 0; axis < 3; ++axis)
            side = std::min(side, glm::length(place.edges[axis]) / field.dims[axis]);
        return side;
    }
    reference::Crossing truth(const Ray& ray) const {
        const glm::dmat3 inverse = glm::inverse(place.edges);
        return reference::first_crossing(field, values,
            inverse * (glm::dvec3(ray.origin) - place.corner), inverse * glm::dvec3(ray.direction),
            double{ray.t0}, double{ray.t1}, ray.start_solid != 0);
    }

private:
    gpu::Device& device_;
    Volume volume_;
    VolumeView view_;

public:
    VolumePlace place;
    reference::TrilinearField field;
    std::vector<double> values; ///< as kernels have them
};

glm::dvec3 random_direction(Pcg32& rng) {
    glm::dvec3 v;
    do {
        v = {rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1)};
    } while (glm::length(v) > 1 || glm::length(v) < 0.1);
    return glm::normalize(v);
}

/// Field values of noise: `levels` equally spaced ones, 0: all.
Volume noise(glm::uvec3 dims, std::uint32_t seed, std::uint32_t levels = 0) {
    Pcg32 rng(seed);
    return float_volume(dims, [&](glm::uvec3) {
        return levels > 0 ? double{static_cast<float>(rng.below(levels))} / (levels - 1)
                          : double{rng.uniform()};
    });
}

class SurfaceSearchTest : public GpuTest {
protected:
    struct Family {
        std::size_t hits = 0, unsure = 0;
        double worst_voxels = 0, worst_degrees = 0;
    };
    /// Every ray of which rounding cannot change the answer has the twin's: hit or not, which
    /// surface, where to 1e-3 of a voxel.
    static Family compare(Scene& scene, const std::vector<Ray>& rays) {
        const std::vector<Hit> hits = scene.find(rays);
        Family family;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const Hit& hit = hits[i];
            EXPECT_EQ(hit.calls, 1u);
            const reference::Crossing truth = scene.truth(rays[i]);
            if (truth.margin < 2e-6) {
                ++family.unsure;
                continue;
            }
            const auto where = testing::Message() << "ray " << i << ", margin " << truth.margin;
            EXPECT_EQ(hit.found != 0, truth.found) << where;
            if (hit.found == 0 || !truth.found) {
                EXPECT_EQ(hit.t, std::max(rays[i].t0, rays[i].t1)) << where;
                continue;
            }
            ++family.hits;
            EXPECT_EQ(hit.surface, truth.value) << where;
            EXPECT_EQ(hit.cut != 0, truth.at_start) << where;
            const double voxels = std::abs(double{hit.t} - truth.t) / scene.voxel();
            EXPECT_LT(voxels, 1e-3) << where;
            family.worst_voxels = std::max(family.worst_voxels, voxels);
            EXPECT_NEAR(double{glm::length(hit.normal)}, 1.0, 1e-5) << where; // no NaN either
        }
        // Where the twin itself is in doubt must stay the exception, or this test says nothing.
        EXPECT_LT(static_cast<double>(family.unsure), 0.005 * static_cast<double>(rays.size()) + 1);
        EXPECT_GT(family.hits, 0u);
        ::testing::Test::RecordProperty("worst_voxels", std::to_string(family.worst_voxels));
        return family;
    }
    static std::vector<Ray> random_rays(
        const Scene& scene, std::size_t count, std::uint32_t seed, bool start_solid = true) {
        Pcg32 rng(seed);
        std::vector<Ray> rays;
        while (rays.size() < count) {
            const glm::dvec3 unit(rng.uniform(), rng.uniform(), rng.uniform());
            const glm::dvec3 target = scene.place.corner + scene.place.edges * unit;
            const glm::dvec3 direction = random_direction(rng);
            const double back = rng.below(4) == 0 ? 0 : 2; // some from inside
            rays.push_back(scene.ray(target - back * direction, direction, start_solid));
        }
        return rays;
    }
};

TEST_F(SurfaceSearchTest, NoiseHasTheSurfacesOfTheTwin) {
    const std::vector<std::vector<double>> isovalues = {
        {0.5}, {0.9}, {0.3, 0.6}, {0.8, 0.2, 0.6, 0.4}};
    std::uint32_t seed = 1;
    for (const std::vector<double>& values : isovalues) {
        SCOPED_TRACE(testing::Message() << values.size() << " isovalues, first " << values[0]);
        Scene scene(device(), noise({8, 8, 8}, seed), values);
        compare(scene, random_rays(scene, 4000, ++seed));
        compare(scene, random_rays(scene, 4000, ++seed, false)); // leaves solids too
    }
}

TEST_F(SurfaceSearchTest, ManyRangeCellsAndAnisotropicVoxels) {
    Volume volume = noise({19, 8, 33}, 5);
    volume.spacing_mm = {1, 2.5, 0.6};
    // Empty space between specks, so that range cells are skipped.
    Pcg32 rng(3);
    for (std::size_t i = 0; i < volume.voxel_count(); ++i)
        if (rng.below(60) != 0) std::memset(&volume.voxels[i * 4], 0, 4);
    Scene scene(device(), std::move(volume), {0.5});
    const Family family = compare(scene, random_rays(scene, 6000, 6));
    EXPECT_GT(family.hits, 100u);
}

TEST_F(SurfaceSearchTest, SaddlesAndCheckerboards) {
    for (const glm::uvec3 dims : {glm::uvec3(2), glm::uvec3(3, 4, 5)}) {
        Scene scene(device(),
            float_volume(dims, [](glm::uvec3 v) { return (v.x + v.y + v.z) % 2; }), {0.5});
        compare(scene, random_rays(scene, 3000, 7));
        Scene off(device(), float_volume(dims, [](glm::uvec3 v) { return (v.x + v.y + v.z) % 2; }),
            {0.49});
        compare(off, random_rays(off, 3000, 8, false));
    }
    Scene thin(device(), noise({1, 1, 1}, 9), {2.0});
    for (const Hit& hit : thin.find(random_rays(thin, 100, 10))) EXPECT_EQ(hit.found, 0u);
}

TEST_F(SurfaceSearchTest, RaysAlongAxesFacesAndDiagonals) {
    Scene scene(device(), noise({8, 8, 8}, 11), {0.5});
    std::vector<Ray> rays;
    Pcg32 rng(12);
    for (int axis = 0; axis < 3; ++axis) {
        for (const double sign : {1.0, -1.0}) {
            glm::dvec3 d(0.0);
            d[axis] = sign;
            for (int i = 0; i <= 32; ++i) { // through voxel centres, faces between, the box's own
                for (int j = 0; j <= 32; ++j) {
                    glm::dvec3 o(-sign * 2.0);
                    o[(axis + 1) % 3] = i / 32.0 - 0.5;
                    o[(axis + 2) % 3] = j / 32.0 - 0.5;
                    rays.push_back(scene.ray(o, d));
                }
            }
            for (int i = 0; i < 300; ++i) { // nearly parallel
                glm::dvec3 o(
                    rng.uniform(-0.5f, 0.5f), rng.uniform(-0.5f, 0.5f), rng.uniform(-0.5f, 0.5f));
                glm::dvec3 bent = d;
                bent[(axis + 1) % 3] = std::pow(10.0, rng.uniform(-30.0f, -3.0f));
                o[axis] = -sign * 2.0;
                rays.push_back(scene.ray(o, bent));
            }
        }
    }
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 d =
            glm::normalize(glm::dvec3(corner & 1, corner >> 1 & 1, corner >> 2) * 2.0 - 1.0);
        for (int i = -8; i <= 8; ++i)
            rays.push_back(scene.ray(-2.0 * d + glm::dvec3(i / 16.0, 0, 0), d));
    }
    compare(scene, rays);
}

TEST_F(SurfaceSearchTest, RaysThatGrazeEdgesOfTheBox) {
    Scene scene(device(), noise({8, 8, 8}, 13), {0.4});
    std::vector<Ray> rays;
    Pcg32 rng(14);
    for (int i = 0; i < 3000; ++i) {
        glm::dvec3 edge(rng.below(2), rng.below(2), rng.below(2));
        edge[static_cast<int>(rng.below(3))] = rng.uniform();
        edge = (edge - 0.5) * (1.0 - std::pow(10.0, rng.uniform(-9.0f, -2.0f)));
        const glm::dvec3 d = random_direction(rng);
        const Ray ray = scene.ray(edge - 2.0 * d, d);
        if (ray.t1 > ray.t0) rays.push_back(ray);
    }
    const std::vector<Hit> hits = scene.find(rays);
    std::size_t found = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const reference::Crossing truth = scene.truth(rays[i]);
        ASSERT_TRUE(std::isfinite(hits[i].t));
        ASSERT_GE(hits[i].t, rays[i].t0);
        ASSERT_LE(hits[i].t, rays[i].t1);
        if (truth.margin > 2e-6) {
            EXPECT_EQ(hits[i].found != 0, truth.found) << i;
        }
        if (hits[i].found == 0) continue;
        ++found;
        EXPECT_NEAR(double{glm::length(hits[i].normal)}, 1.0, 1e-5);
    }
    EXPECT_GT(found, 100u);
}

TEST_F(SurfaceSearchTest, PlateausAtTheIsovalueAreInside) {
    // Values 0, 1/2 and 1, isovalue 1/2: along the voxels' lines every value is exact.
    Scene scene(device(), noise({8, 8, 8}, 15, 3), {0.5});
    std::vector<Ray> rays;
    for (int axis = 0; axis < 3; ++axis)
        for (int i = 0; i < 8; ++i)
            for (int j = 0; j < 8; ++j)
                for (const double sign : {1.0, -1.0}) {
                    glm::dvec3 d(0.0), o(-2.0 * sign);
                    d[axis] = sign;
                    o[(axis + 1) % 3] = (i + 0.5) / 8 - 0.5;
                    o[(axis + 2) % 3] = (j + 0.5) / 8 - 0.5;
                    rays.push_back(scene.ray(o, d));
                }
    const std::vector<Hit> hits = scene.find(rays);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const reference::Crossing truth = scene.truth(rays[i]);
        ASSERT_EQ(hits[i].found != 0, truth.found) << i;
        if (truth.found) {
            EXPECT_NEAR(double{hits[i].t}, truth.t, 1e-3 * scene.voxel()) << i;
        }
    }
}

TEST_F(SurfaceSearchTest, CrossingsOnTheFacesOfCellsFallThroughNoCrack) {
    // The field is the layer's number, the isovalue a layer's: cells end or begin just there.
    // Frames put isovalues 2^-22 lower, this one on the layer itself.
    Scene scene(
        device(), float_volume({8, 8, 8}, [](glm::uvec3 v) { return v.z; }), {4 * (1 + 0x1p-22)});
    const std::vector<Ray> rays = random_rays(scene, 40000, 22, false);
    const std::vector<Hit> hits = scene.find(rays);
    ASSERT_EQ(scene.values[0], 4.0);
    const double layer = 4.5 / 8 - 0.5;
    std::size_t crossings = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const double o = double{rays[i].origin.z}, d = double{rays[i].direction.z};
        const double t = (layer - o) / d;
        if (t < double{rays[i].t0} + 1e-4 || t > double{rays[i].t1} - 1e-4) continue;
        ++crossings;
        ASSERT_EQ(hits[i].found, 1u) << i;
        ASSERT_NEAR(double{hits[i].t}, t, 2e-4 / std::abs(d) * scene.voxel()) << i;
    }
    EXPECT_GT(crossings, 10000u);
}

TEST_F(SurfaceSearchTest, NormalsFollowTheGradientAndNeverFail) {
    Volume volume = noise({8, 8, 8}, 16);
    volume.spacing_mm = {1, 2, 3};
    volume.direction = {{0, 1, 0}, {0.6, 0, 0.8}, {0, 0.28, 0.96}}; // sheared, left-handed
    ASSERT_LT(glm::determinant(volume.direction), 0);
    Scene scene(device(), std::move(volume), {0.5});
    const std::vector<Ray> rays = random_rays(scene, 2000, 17);
    const std::vector<Hit> hits = scene.find(rays);
    const glm::dmat3 inverse = glm::inverse(scene.place.edges);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const Ray& ray = rays[i];
        if (hits[i].found == 0) continue;
        if (hits[i].cut != 0) {
            EXPECT_EQ(hits[i].normal, -ray.direction);
            continue;
        }
        const glm::dvec3 position =
            glm::dvec3(ray.origin) + double{hits[i].t} * glm::dvec3(ray.direction);
        const glm::dvec3 unit = inverse * (position - scene.place.corner);
        const glm::dvec3 gradient = glm::transpose(inverse) * scene.field.gradient(unit);
        if (glm::length(gradient) < 1e-2) continue;
        EXPECT_GT(glm::dot(-glm::normalize(gradient), glm::dvec3(hits[i].normal)), 1 - 1e-4) << i;
    }
    // Where the gradient vanishes: a solid that fills the box, met at its face; and inside.
    Scene solid(device(), float_volume({4, 4, 4}, [](glm::uvec3) { return 1.0; }), {0.5});
    Ray ray = solid.ray({0, 0, 2}, {0, 0, -1});
    ray.entry_normal = {0, 0, 1};
    const Hit face = solid.find({ray})[0];
    EXPECT_EQ(face.t, ray.t0);
    EXPECT_EQ(face.normal, glm::vec3(0, 0, 1));
    EXPECT_EQ(face.cut, 1u);
    const Hit inside = solid.find({solid.ray({0.1, 0, 0}, {0, 1, 0})})[0];
    EXPECT_EQ(inside.found, 1u);
    EXPECT_EQ(inside.t, 0.0f);
    EXPECT_EQ(inside.normal, glm::vec3(0, -1, 0));
    const Hit leaving = solid.find({solid.ray({0.1, 0, 0}, {0, 1, 0}, false)})[0];
    EXPECT_EQ(leaving.found, 0u) << "nothing is crossed between here and the box's end";
    // A spike whose central differences cancel where rays meet it head on.
    Scene sheet(device(), float_volume({8, 8, 8}, [](glm::uvec3 v) { return v.z == 4; }), {1.0});
    for (const Hit& hit : sheet.find({sheet.ray({0.01, 0.02, 2}, {0, 0, -1})})) {
        EXPECT_EQ(hit.found, 1u);
        EXPECT_NEAR(glm::length(hit.normal), 1.0f, 1e-5f);
    }
}

TEST_F(SurfaceSearchTest, BudgetsDoNotChangeABit) {
    Volume volume = noise({40, 40, 40}, 18);
    Pcg32 rng(19);
    for (std::size_t i = 0; i < volume.voxel_count(); ++i)
        if (rng.below(40) != 0) std::memset(&volume.voxels[i * 4], 0, 4);
    Scene scene(device(), std::move(volume), {0.55, 0.97});
    const std::vector<Ray> rays = random_rays(scene, 3000, 20);
    const std::vector<Hit> whole = scene.find(rays);
    std::uint32_t most_calls = 0;
    for (const std::uint32_t budget : {1u, 7u, 64u}) {
        const std::vector<Hit> parts = scene.find(rays, budget);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            most_calls = std::max(most_calls, parts[i].calls);
            ASSERT_EQ(parts[i].found, whole[i].found) << i << ", budget " << budget;
            ASSERT_EQ(parts[i].surface, whole[i].surface) << i;
            ASSERT_EQ(
                std::bit_cast<std::uint32_t>(parts[i].t), std::bit_cast<std::uint32_t>(whole[i].t))
                << i;
            ASSERT_EQ(parts[i].normal, whole[i].normal) << i;
        }
    }
    EXPECT_GT(most_calls, 20u) << "searches were interrupted";
}

TEST_F(SurfaceSearchTest, ThinShellsAreNeverMissed) {
    // One voxel above the isovalue, 1/64 down to 1/1024 of the box thick.
    for (const std::uint32_t thickness : {64u, 256u, 1024u}) {
        const double value = 1.0 - 0.5 * 128 / thickness + (thickness == 64 ? 1e-3 : 0.0);
        Scene scene(
            device(), float_volume({4, 4, 128}, [](glm::uvec3 v) { return v.z == 77; }), {value});
        std::vector<Ray> rays;
        Pcg32 rng(21);
        while (rays.size() < 4000) {
            const glm::dvec3 at(rng.uniform(-0.01f, 0.01f), rng.uniform(-0.01f, 0.01f), 0.2);
            const glm::dvec3 aside = 0.01 * random_direction(rng);
            const glm::dvec3 d =
                glm::normalize(glm::dvec3(aside.x, aside.y, rng.below(2) ? 1.0 : -1.0));
            rays.push_back(scene.ray(at - 2.0 * d, d));
        }
        for (const Hit& hit : scene.find(rays)) ASSERT_EQ(hit.found, 1u) << "1/" << thickness;
    }
}

} // namespace
} // namespace ockham::test

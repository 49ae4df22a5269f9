// SPDX-License-Identifier: Apache-2.0
// Isosurfaces of scanned volumes, found exactly, against the brute-force twin. Registered where
// OCKHAM_DATA_DIR is set; surface_search_test has generated fields that are worse.
#include "framework/io/volume_file.hpp"
#include "passes/volume/surface_depth.hpp"
#include "tests/reference/trilinear_surface.hpp"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/volume_bench.hpp"

#include <cmath>

namespace ockham::test {
namespace {

class SurfaceDataTest : public GpuTest {
protected:
    /// 64 x 48 rays from the front, and from above and aside.
    static void compare(const char* file, double isovalue) {
        const Volume volume = load_volume(std::string(OCKHAM_DATA_DIR) + "/volumes/" + file);
        for (const Camera& camera :
            {volume_camera(), look_at({1.4f, -1.5f, 1.7f}, {0, 0, 0}, 30, UpAxis::z)}) {
            VolumeView view;
            view.surfaces.push_back({.value = isovalue});
            VolumeBench bench(device(), volume, linear_transfer(),
                {.view = view, .width = 64, .height = 48, .camera = camera});
            const SurfaceDepth out = add_surface_depth(bench.graph, bench.inputs,
                {.width = 64, .height = 48}, bench.graph.add_condition("restart"));
            bench.graph.export_resource(out.depth, "test");
            bench.execute();
            const Image image = bench.read(out.depth);

            reference::TrilinearField field{glm::ivec3(volume.dims), {}};
            for (int z = 0; z < field.dims.z; ++z)
                for (int y = 0; y < field.dims.y; ++y)
                    for (int x = 0; x < field.dims.x; ++x)
                        field.voxels.push_back(bench.gpu.texel_of(volume.at({x, y, z})));
            const VolumePlace place = place_of(volume);
            const glm::dmat3 inverse = glm::inverse(place.edges);
            const std::vector<double> values{double{bench.frame.surfaces[0].value}};
            std::size_t hits = 0, unsure = 0;
            for (int i = 0; i < 64 * 48; ++i) {
                const glm::dvec2 p(2 * (i % 64 + 0.5) / 64 - 1, 1 - 2 * (i / 64 + 0.5) / 48);
                const glm::dvec3 o = inverse * (glm::dvec3(bench.frame.position) - place.corner);
                const glm::dvec3 d = inverse * glm::normalize(glm::dvec3(bench.frame.forward) +
                                                              p.x * glm::dvec3(bench.frame.right) +
                                                              p.y * glm::dvec3(bench.frame.up));
                const glm::dvec3 a = -o / d, b = (1.0 - o) / d;
                const glm::dvec3 enter = glm::min(a, b), leave = glm::max(a, b);
                const double near = std::max({0.0, enter.x, enter.y, enter.z});
                const double far = std::min({leave.x, leave.y, leave.z});
                if (near > far - 1e-5) continue;
                const reference::Crossing truth =
                    reference::first_crossing(field, values, o, d, near, far, true, 20);
                if (truth.margin < 3e-6) {
                    ++unsure;
                    continue;
                }
                const double depth = double{image.plane(0)[i]};
                ASSERT_EQ(image.plane(1)[i] > 0, truth.found) << "pixel " << i;
                if (!truth.found || truth.at_start) continue;
                ++hits;
                const double voxels_per_unit = glm::length(d * glm::dvec3(field.dims));
                ASSERT_NEAR((near + depth * (far - near)) * voxels_per_unit,
                    truth.t * voxels_per_unit, 1e-3)
                    << "pixel " << i;
            }
            EXPECT_GT(hits, 300u);
            EXPECT_LT(unsure, 15u);
        }
    }
};

TEST_F(SurfaceDataTest, Engine) { compare("engine.json", 110.5); }
TEST_F(SurfaceDataTest, Cranium) { compare("cranium_ct.json", 300); }
TEST_F(SurfaceDataTest, Headsq) { compare("headsq.json", 1100.5); }

} // namespace
} // namespace ockham::test

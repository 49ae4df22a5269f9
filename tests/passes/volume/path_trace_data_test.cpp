// SPDX-License-Identifier: Apache-2.0
// A smooth float grid of the external data, against a quadrature and an independent analog tracer.
#include "framework/io/volume_file.hpp"
#include "tests/support/path_case.hpp"

namespace ockham::test {
namespace {

class PathTraceData : public PathTest {
protected:
    /// bump64 at an extinction of 20 per value.
    static Case bump(float albedo) {
        Case it = cube(20, albedo);
        it.volume = load_volume(OCKHAM_DATA_DIR "/volumes/bump64.json");
        return it;
    }
};

TEST_F(PathTraceData, SmoothGridHasTheValuesOfAnIndependentTracer) {
    const Family family(3);
    family.expect(trace(bump(0)).mean[0], .56503, "absorption");
    Case white = bump(0.8f);
    white.options.view.seed = 2;
    family.expect(trace(white).mean[0], {.80917, .0002}, "white environment");
    Case sun = bump(0.8f);
    sun.options.view.seed = 3;
    sun.options.view.environment = glm::vec3(0.0f);
    sun.options.view.light_direction = {0, 0, -1};
    sun.options.view.light_irradiance = glm::vec3(std::numbers::pi_v<float>);
    family.expect(trace(sun).mean[0], {.09421, .00008}, "sun");
}

} // namespace
} // namespace ockham::test

// SPDX-License-Identifier: Apache-2.0
// Pictures for the tests of known failures of adaptive anti-aliasing: the paper's method and ours
// on one scene, beside all samples. Not for identities: see adaptive_aa_test.cpp.
#pragma once

#include "framework/core/image.hpp"
#include "passes/pipelines/adaptive_aa.hpp"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/surface_scenes.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace ockham::test {

class AaFailures : public GpuTest {
protected:
    struct Picture {
        Image radiance; ///< R, G, B, A
        Image counts;   ///< k; empty where it is the same everywhere
        double percent; ///< of all samples

        int k(int x, int y) const { return static_cast<int>(counts.at(x, y, 0)); }
        int most() const {
            return static_cast<int>(
                *std::max_element(counts.plane(0).begin(), counts.plane(0).end()));
        }
    };

    /// The paper as printed, with its default constants.
    static AdaptiveAaParams paper(int width, int height, int m = 4) {
        AdaptiveAaParams p;
        p.width = static_cast<std::uint32_t>(width);
        p.height = static_cast<std::uint32_t>(height);
        p.m = static_cast<std::uint32_t>(m);
        p.metrics = default_metrics(p.m);
        p.export_counts = true;
        return p;
    }
    /// Ours, as by default. `lambda`: squared error that a sample must remove, in display-encoded
    /// values.
    static AdaptiveAaParams ours(int width, int height, int m = 4, float lambda = kDefaultLambda) {
        AdaptiveAaParams p = paper(width, height, m);
        p.metric = MetricKind::ockham;
        p.lambda = lambda;
        p.resolve = Resolve::stratified;
        p.order_kind = SampleOrder::optimal;
        p.filter_highlights = true;
        return p;
    }
    static AdaptiveAaParams all_samples(int width, int height, int m = 4) {
        AdaptiveAaParams p = paper(width, height, m);
        p.method = AaMethod::ssaa;
        return p;
    }
    static Picture render(const LitScene& lit, const Camera& camera, const AdaptiveAaParams& p) {
        AdaptiveAa aa(device(), lit, camera, p);
        aa.execute();
        const ImageHandle map = aa.outputs().sample_count;
        return {aa.picture(), map ? aa.executor().read(map) : Image(), aa.sample_counts().percent};
    }
    static Picture render(const Scene& scene, const Camera& camera, const AdaptiveAaParams& p) {
        const LitScene lit(device(), scene);
        return render(lit, camera, p);
    }
    /// Largest difference of the green channel, over all pixels or those where `where` holds.
    template <class Where>
    static float largest_error(const Image& a, const Image& b, Where where) {
        float most = 0;
        for (int y = 0; y < a.height(); ++y)
            for (int x = 0; x < a.width(); ++x)
                if (where(x, y)) most = std::max(most, std::abs(a.at(x, y, 1) - b.at(x, y, 1)));
        return most;
    }
    static float largest_error(const Image& a, const Image& b) {
        return largest_error(a, b, [](int, int) { return true; });
    }
    static double mean(const Image& image, int first_row, int rows) {
        double sum = 0;
        for (int y = first_row; y < first_row + rows; ++y)
            for (int x = 0; x < image.width(); ++x) sum += image.at(x, y, 1);
        return sum / (double(rows) * image.width());
    }
    /// Of 16 x 16 samples: 8 x 8 at twice the size, then the mean of two by two.
    static Image truth(const LitScene& lit, const Camera& camera, int width, int height) {
        const Image large = render(lit, camera, all_samples(2 * width, 2 * height, 8)).radiance;
        Image half(width, height, {"R", "G", "B", "A"});
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                for (int c = 0; c < 4; ++c)
                    half.at(x, y, c) =
                        0.25f *
                        (large.at(2 * x, 2 * y, c) + large.at(2 * x + 1, 2 * y, c) +
                            large.at(2 * x, 2 * y + 1, c) + large.at(2 * x + 1, 2 * y + 1, c));
        return half;
    }
};

} // namespace ockham::test

// SPDX-License-Identifier: Apache-2.0
// How well and how fast the three searches find the first isosurface along camera rays, beside a
// truth that shares nothing with them. Called by the volume suite.
#pragma once

#include "passes/volume/surface_depth.hpp"
#include "samples/chart/volume_runs.hpp"

#include <vector>

namespace ockham::chart {

/// First crossing of the rays through pixel centres, as a fraction of their way through the box;
/// below 0: none. By steps of 1/16 voxel along the ray in double precision, then bisection: it
/// knows no cells, and misses only what is thinner.
std::vector<double> surface_truth(
    const Volume& volume, double isovalue, const Camera& camera, std::uint32_t side);

/// Values of a row: lookups (candidates or steps per ray; the knob), gpu_ms, wrong_percent (pixels
/// that miss a surface, see one where there is none, or are off by more than a voxel),
/// error_voxels (root mean square of the hits that are not wrong). Stochastic: rows over 1, 2, 4
/// ... candidates, which is one run that goes on; march: over the steps; exact: one.
class SurfaceSearchRun : public Subject {
public:
    SurfaceSearchRun(gpu::Device& device, const VolumeScene& scene, SurfaceSearch search,
        std::uint32_t side, std::uint32_t most);
    ~SurfaceSearchRun() override;
    std::vector<Row> measure() override;

private:
    struct Searcher;
    std::unique_ptr<Searcher> searcher(std::uint32_t lookups);
    Row judge(Searcher& searcher, std::uint32_t lookups, double milliseconds) const;

    gpu::Device& device_;
    VolumeSource source_;
    Camera camera_;
    SurfaceSearch search_;
    std::uint32_t side_, most_;
    VolumeGpu gpu_;
    std::vector<double> truth_, voxels_; ///< per pixel; voxels along the ray's way through the box
    std::vector<std::unique_ptr<Searcher>> searchers_; ///< march: one for each count of steps
};

} // namespace ockham::chart

// SPDX-License-Identifier: Apache-2.0
// Table 1 and figures 3 to 9 of Smajdek et al. 2023, its frame rates and its memory, measured on
// volumes at hand. Part of the papers suite.
#pragma once

#include "samples/chart/volume_runs.hpp"

#include <map>
#include <string>
#include <vector>

namespace ockham::chart {

/// Rows of table 1: voxels along a cell, and two of this program's own formats.
struct CacheKind {
    std::uint32_t scale;
    CacheFormat format;
    const char* title;
};
inline constexpr CacheKind kCaches[] = {{1, CacheFormat::fp32, "1, 32-bit"},
    {1, CacheFormat::fp16, "1, 16-bit"}, {2, CacheFormat::fp32, "2, 32-bit"},
    {4, CacheFormat::fp32, "4, 32-bit"}, {2, CacheFormat::fp16, "2, 16-bit (default here)"},
    {2, CacheFormat::rgb9e5, "2, shared exponent"}};

inline constexpr const char* kPaperShadings[] = {"lambert", "phong", "disney"};

class PaperVolume {
public:
    /// Adds its jobs; `context` and `list` must outlive this object.
    PaperVolume(Context& context, JobList& list);
    /// In paper_volume_report.cpp.
    void report(const Store& store, const std::vector<Point>& points, Section& section) const;

private:
    class Moments;
    void add(const VolumeScene& scene, const std::string& series, const std::string& flags,
        JobList::Open open, JobList& list);
    VolumeGiParams params(VolumeMode mode) const;
    std::vector<Row> converged(const VolumeScene& scene, std::map<std::string, Picture>& shown);
    std::vector<Row> caches(const VolumeScene& scene);
    std::vector<Row> frame_rates(const VolumeScene& scene);
    std::vector<Row> memory(const VolumeScene& scene);
    std::vector<Plot> convergence_plots(const std::vector<Point>& points) const;
    std::vector<Plot> metric_plots(const Store& store, const std::vector<Point>& points) const;
    std::map<std::string, std::string> pictures_of(
        const Store& store, const std::string& series) const;
    Table cache_table(const std::vector<Point>& points) const;
    Table speed_table(const std::vector<Point>& points) const;
    Table memory_table(const std::vector<Point>& points) const;
    Table picture_table(const std::vector<Point>& points) const;
    void add_wipes(const Store& store, Section& section) const;

    Context& context_;
    std::uint32_t side_, frame_side_;
    int most_;                              ///< executions that refine a cache
    double seconds_;                        ///< that stand for the paper's 30
    std::vector<VolumeScene> scenes_;       ///< with isosurfaces; the first for figures 3, 4, 7
    std::vector<VolumeScene> small_scenes_; ///< of table 1, where each voxel has a cell
    VolumeReferences references_;
    std::vector<Job> jobs_;
};

} // namespace ockham::chart

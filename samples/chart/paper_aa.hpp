// SPDX-License-Identifier: Apache-2.0
// Table 1 and figures 5, 7 and 8 of Hollaender et al. 2013, and what its section 4.2 says of ways
// to dispatch, measured on a scene at hand. Part of the papers suite.
#pragma once

#include "passes/pipelines/aa_options.hpp"
#include "passes/pipelines/adaptive_aa.hpp"
#include "samples/chart/volume_runs.hpp"

#include <memory>
#include <string>
#include <vector>

namespace ockham::chart {

class PaperAa {
public:
    /// Adds its jobs; `context` and `list` must outlive this object.
    PaperAa(Context& context, JobList& list);
    void report(const Store& store, const std::vector<Point>& points, Section& section) const;

private:
    class Window;
    Job job(const std::string& series, const std::string& flags, int repeats) const;
    const LitScene& lit();
    AdaptiveAaParams params(
        std::uint32_t m, const std::string& method, const std::string& preset = "ockham") const;
    AdaptiveAaParams as_paper(std::uint32_t m) const;
    AdaptiveAaParams as_default(std::uint32_t m) const;
    std::vector<Row> figure_5(std::map<std::string, Picture>& shown);
    std::vector<Row> figure_8(std::map<std::string, Picture>& shown);
    std::vector<Row> dispatches();
    Table table_1(const std::vector<Point>& points) const;
    Table figure_table(const std::vector<Point>& points) const;
    Wipe wipe(const Store& store, const std::string& series, const std::string& title,
        const std::vector<std::pair<std::string, std::string>>& sides,
        const std::string& caption) const;

    Context& context_;
    std::string scene_, rig_; ///< rig_: of scenes that are files; empty: none
    std::uint32_t width_, height_;
    std::unique_ptr<LitScene> lit_; ///< when it is first needed
    Camera camera_;
    std::vector<Job> jobs_;
};

} // namespace ockham::chart

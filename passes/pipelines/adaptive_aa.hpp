// SPDX-License-Identifier: Apache-2.0
// The picture of aa_graph.hpp with its executor: chooses the layout of the G-buffer that fits, cuts
// the picture into screen tiles where it must, follows a camera, counts samples. Called by samples.
#pragma once

#include "passes/pipelines/aa_graph.hpp"
#include "passes/pipelines/lit_scene.hpp"
#include "passes/surface/frame.hpp"

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace ockham {

/// The graph with its executor. `device` and `scene` must outlive it.
class AdaptiveAa {
public:
    /// Throws Error(input) for parameters out of range, Error(device) for want of memory.
    AdaptiveAa(gpu::Device& device, const LitScene& scene, const Camera& camera,
        const AdaptiveAaParams& params);

    /// The whole picture: one execution of the graph for each screen tile.
    void execute();
    /// Looks from elsewhere from the next execution on. The plan stays as it is.
    void set_camera(const Camera& camera);
    /// Where the part lies whose size is the picture's, from the next execution on; zero at first.
    /// With AdaptiveAaParams::part_of only.
    void set_origin(glm::uvec2 origin);
    const AdaptiveAaOutputs& outputs() const { return outputs_; }
    Executor& executor() { return *executor_; }
    /// R, G, B (linear radiance) and A of the last execution.
    Image picture() { return read(outputs_.radiance); }
    /// One of the outputs but captures, of the whole picture.
    Image read(ImageHandle image);
    /// GPU times of the last execution's passes, summed over the tiles.
    const std::vector<PassTime>& times() const { return view_ ? times_ : executor_->times(); }

    /// How the picture came to fit.
    struct Fit {
        GbufferLayout layout = GbufferLayout::packed;
        glm::uvec2 tile{0}; ///< pixels, apron included; the picture's own size if there is one
        std::string reason; ///< why not packed and whole; empty: it is, or was asked for
    };
    const Fit& fit() const { return fit_; }
    /// Screen tiles of an execution.
    std::size_t tile_count() const { return tiles_.size(); }
    /// Samples that pixels took in all, and how often each count occurred: histogram[k - 1].
    struct SampleCounts {
        double percent = 0; ///< of all m * m samples, each pixel's first included
        double mean = 0;    ///< k
        std::vector<std::uint64_t> histogram;
        /// Useful share of SIMD lanes, were the dispatch run in groups of `lanes`:
        /// passes/schedule/dispatch.hpp.
        double lane_efficiency = 1;
        /// percent, plus first samples that pixels with k = n shade a second time.
        double shaded_percent = 0;
    };
    SampleCounts sample_counts(std::uint32_t lanes = 8);

private:
    const LitScene* lit_;
    AdaptiveAaParams params_;
    AdaptiveAaOutputs outputs_;
    std::uint32_t max_extent_; ///< of attachments and viewports
    Fit fit_;
    std::vector<TilePlacement> tiles_;
    glm::uvec2 origin_{0};                              ///< of all tiles, where it is a part
    std::unique_ptr<ScreenTile> view_;                  ///< null: one tile, the whole picture
    shader::FrameData whole_{};                         ///< of the whole picture, before any jitter
    std::uint32_t executed_ = 0;                        ///< frames so far
    std::unique_ptr<gpu::Buffer> frame_, frame_before_; ///< before: with history only
    std::unique_ptr<Executor> executor_;
    std::vector<ImageHandle> kept_;        ///< exported
    std::map<ResourceId, Image> pictures_; ///< assembled, where there are several tiles
    std::vector<PassTime> times_;

    struct Declared {
        Graph graph{"adaptive_aa"};
        ShadingInputs in;
        AdaptiveAaOutputs outputs;
    };
    Declared declare(const Fit& fit) const;
    Fit choose_fit(gpu::Device& device) const;
    std::string obstacle(gpu::Device& device, const Fit& fit) const;
    std::string refusal(gpu::Device& device, const std::optional<Fit>& fit) const;
    /// What the next execution of the graph shows.
    void aim(const TilePlacement& tile);
};

} // namespace ockham

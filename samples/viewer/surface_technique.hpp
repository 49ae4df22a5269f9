// SPDX-License-Identifier: Apache-2.0
// Scenes with adaptive supersampling in the viewer: two pictures, a small one for haste and a full
// one, of one uploaded scene. Called by the viewer.
#pragma once

#include "framework/app/scene_source.hpp"
#include "passes/pipelines/aa_options.hpp"
#include "passes/pipelines/adaptive_aa.hpp"
#include "samples/viewer/technique.hpp"

#include <memory>

namespace ockham::viewer {

struct SurfaceOptions {
    SceneOptions scene;
    AaOptions method;
};
void declare(Params& params, SurfaceOptions& options);

/// Where `common` says, or the scene.
Stage stage_of(const LitScene& lit, const CommonOptions& common);

/// The samples of a pixel that `method` makes, from their picture of m x m pixels. `counts`: k of
/// each pixel where they differ.
SampleGrid sample_grid(const Image& samples, const AdaptiveAaParams& method,
    const std::optional<Image>& counts, glm::ivec2 pixel);

class SurfaceTechnique : public Technique {
public:
    /// Loads and uploads; all must outlive this object. Throws Error(input) naming the file.
    SurfaceTechnique(
        gpu::Device& device, const CommonOptions& common, const SurfaceOptions& options);

    /// The same scene by other options.
    SurfaceTechnique(gpu::Device& device, const CommonOptions& common,
        std::shared_ptr<const LitScene> lit, const SurfaceOptions& options);

    const char* program() const override { return "adaptive_aa"; }
    std::string title() const override;
    Stage stage() const override { return stage_of(*lit_, common_); }
    void change(const std::vector<std::string>& names) override;
    void set_camera(const Camera& camera) override;
    void render(glm::uvec2 size, bool hurry) override;
    bool finished() const override { return finished_; }
    Image picture() override { return shown_->picture(); }
    std::vector<std::string> overlays() const override;
    void want_overlay(const std::string& name) override;
    std::optional<Overlay> overlay(const std::string& name) override;
    std::optional<SampleGrid> samples(glm::ivec2 pixel) override;
    void forget_samples() override { samples_ = {}; }
    std::string method() const override { return options_.method.method; }
    std::vector<std::string> rivals() const override;
    std::unique_ptr<Technique> rival(const std::string& name) override;
    std::vector<std::pair<std::string, std::string>> facts() override;
    Executor* executor() override { return shown_ ? &shown_->executor() : nullptr; }
    std::vector<PassTime> times() override;

private:
    /// One picture, made anew when something but the camera changes.
    struct Slot {
        std::unique_ptr<AdaptiveAa> aa;
        glm::uvec2 size{0};
    };
    void load();
    void forget();
    AdaptiveAa& slot(glm::uvec2 size, bool hurry);
    Image cluster_counts();

    gpu::Device& device_;
    const CommonOptions& common_;
    std::optional<SurfaceOptions> own_; ///< of a rival
    const SurfaceOptions& options_;
    std::shared_ptr<const LitScene> lit_;
    AdaptiveAaParams params_;
    Camera camera_;
    Slot hasty_, full_;
    Slot samples_;  ///< of one pixel of a picture of that size
    Slot clusters_; ///< one sample for each surface: its counts are an overlay
    AdaptiveAa* shown_ = nullptr;
    std::string wanted_;
    int frames_ = 0; ///< of one view, that is not in a hurry
    bool finished_ = false;
};

} // namespace ockham::viewer

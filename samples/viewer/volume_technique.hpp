// SPDX-License-Identifier: Apache-2.0
// Volumes with global illumination in the viewer: one graph that changes its size; while something
// is dragged it composes from the cache, and the cache outlives the change. Called by the viewer.
#pragma once

#include "framework/app/volume_source.hpp"
#include "framework/scene/histogram.hpp"
#include "passes/pipelines/volume_gi_options.hpp"
#include "samples/viewer/technique.hpp"

#include <memory>

namespace ockham::viewer {

struct VolumeViewerOptions {
    VolumeOptions volume;
    VolumeGiOptions method;
    int steps = 256;
};
void declare(Params& params, VolumeViewerOptions& options);

class VolumeTechnique : public Technique {
public:
    /// Loads and uploads; all must outlive this object. Throws Error(input) naming the file.
    VolumeTechnique(
        gpu::Device& device, const CommonOptions& common, const VolumeViewerOptions& options);

    /// The same volume by other options.
    VolumeTechnique(gpu::Device& device, const CommonOptions& common, const VolumeSource& source,
        const VolumeViewerOptions& options);

    const char* program() const override { return "volume_gi"; }
    std::string title() const override;
    Stage stage() const override;
    void change(const std::vector<std::string>& names) override;
    void set_camera(const Camera& camera) override;
    void render(glm::uvec2 size, bool hurry) override;
    bool finished() const override { return finished_; }
    Image picture() override { return gi_->picture(); }
    std::vector<std::string> overlays() const override;
    void want_overlay(const std::string&) override {}
    std::optional<Overlay> overlay(const std::string& name) override;
    std::vector<std::string> rivals() const override;
    std::unique_ptr<Technique> rival(const std::string& name) override;
    std::vector<std::pair<std::string, std::string>> facts() override;
    Executor* executor() override { return gi_ ? &gi_->executor() : nullptr; }
    std::vector<PassTime> times() override;

    const Histogram& histogram() const { return histogram_; }
    const TransferFunction& transfer() const { return source_.transfer; }
    const Volume& volume() const { return source_.volume; }
    /// As if drawn in a file. Throws Error(input).
    void set_transfer(const TransferFunction& transfer);

private:
    void load();
    VolumeMode mode() const;

    gpu::Device& device_;
    const CommonOptions& common_;
    std::optional<VolumeViewerOptions> own_; ///< of a rival
    const VolumeViewerOptions& options_;
    VolumeSource source_;
    Histogram histogram_;
    Camera camera_;
    std::unique_ptr<VolumeGi> gi_; ///< null: to be made by the next render()
    glm::uvec2 size_{0};
    bool gather_ = true;
    bool finished_ = false;
};

} // namespace ockham::viewer

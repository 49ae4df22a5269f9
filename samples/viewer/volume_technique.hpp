// SPDX-License-Identifier: Apache-2.0
// Volumes with global illumination in the viewer: one graph that changes its size; while something
// is dragged it composes from the cache, and the cache outlives the change. With meshes around it:
// surface_volume_technique.hpp. Called by the viewer.
#pragma once

#include "framework/app/volume_source.hpp"
#include "framework/scene/histogram.hpp"
#include "passes/pipelines/surface_volume.hpp"
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
/// All but what says which volume, for techniques that have more than one.
void declare_method(Params& params, VolumeViewerOptions& options);

class VolumeTechnique : public Technique {
public:
    /// Loads; all must outlive this object. Throws Error(input) naming the file.
    VolumeTechnique(
        gpu::Device& device, const CommonOptions& common, const VolumeViewerOptions& options);

    /// The same volume by other options, which are copied; at `place`, if there is one. Give it a
    /// camera before the first step.
    VolumeTechnique(gpu::Device& device, const CommonOptions& common, VolumeSource source,
        const VolumeViewerOptions& options, const std::optional<VolumePlace>& place);

    const char* program() const override { return "volume_gi"; }
    std::string title() const override;
    Stage stage() const override;
    void change(const std::vector<std::string>& names) override;
    void set_camera(const Camera& camera) override;
    void render(glm::uvec2 size, bool hurry) override;
    bool finished() const override { return finished_; }
    Image picture() override { return picture_->picture(); }
    std::vector<std::string> overlays() const override;
    void want_overlay(const std::string&) override {}
    std::optional<Overlay> overlay(const std::string& name) override;
    std::string method() const override { return name_of(mode()); }
    std::vector<std::string> rivals() const override;
    std::unique_ptr<Technique> rival(const std::string& name) override;
    std::vector<std::pair<std::string, std::string>> facts() override;
    Executor* executor() override { return picture_ ? &picture_->executor() : nullptr; }
    std::vector<PassTime> times() override;

    const Histogram& histogram() const { return histogram_; }
    const TransferFunction& transfer() const { return source_.transfer; }
    /// As if drawn in a file. Throws Error(input).
    virtual void set_transfer(const TransferFunction& transfer);

protected:
    /// Of a volume that is still to be take()n; `options` must outlive this object.
    struct Empty {};
    VolumeTechnique(gpu::Device& device, const CommonOptions& common,
        const VolumeViewerOptions& options, Empty);

    /// All from the files anew; the view from the options; the picture from both.
    virtual void load();
    virtual void relight();
    virtual std::unique_ptr<SurfaceVolume> make(const VolumeGiParams& params) const;

    void take(VolumeSource source, const std::optional<VolumePlace>& place);
    /// The next step makes it from nothing.
    void forget();
    VolumeMode mode() const;

    gpu::Device& device_;
    const CommonOptions& common_;
    VolumeSource source_;
    std::optional<VolumePlace> place_; ///< empty: place_of() the volume
    Camera camera_;
    std::unique_ptr<SurfaceVolume> picture_; ///< null: to be made by the next render()
    glm::uvec2 size_{0};                     ///< of it, pixels

private:
    /// Null before the first step, and where meshes hide that the medium is transparent.
    VolumeGi* medium() const { return picture_ ? picture_->medium() : nullptr; }

    std::optional<VolumeViewerOptions> own_; ///< of a rival
    const VolumeViewerOptions& options_;
    Histogram histogram_;
    bool gather_ = true;
    bool finished_ = false;
};

} // namespace ockham::viewer

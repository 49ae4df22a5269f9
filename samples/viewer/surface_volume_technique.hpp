// SPDX-License-Identifier: Apache-2.0
// Scenes with a volume among them in the viewer: what volume_technique.hpp does of the volume, with
// meshes around it and the light of both. Called by the viewer.
#pragma once

#include "samples/surface_volume/world.hpp"
#include "samples/viewer/surface_technique.hpp"
#include "samples/viewer/volume_technique.hpp"

namespace ockham::viewer {

struct SurfaceVolumeOptions {
    WorldOptions world;
    SurfaceOptions surface;
    VolumeViewerOptions volume;
};
void declare(Params& params, SurfaceVolumeOptions& options);

class SurfaceVolumeTechnique : public VolumeTechnique {
public:
    /// Loads and uploads; all must outlive this object. Throws Error(input) naming the file, also
    /// where there is no scene or no volume.
    SurfaceVolumeTechnique(
        gpu::Device& device, const CommonOptions& common, const SurfaceVolumeOptions& options);

    /// The same world by other options, which are copied. Give it a camera before the first step.
    SurfaceVolumeTechnique(gpu::Device& device, const CommonOptions& common,
        std::shared_ptr<const LitScene> lit, const VolumeSource& source,
        const SurfaceVolumeOptions& options);

    const char* program() const override { return "surface_volume"; }
    std::string title() const override;
    Stage stage() const override { return stage_of(*lit_, common_); }
    void change(const std::vector<std::string>& names) override;
    void set_camera(const Camera& camera) override;
    void render(glm::uvec2 size, bool hurry) override;
    void set_transfer(const TransferFunction& transfer) override;
    std::vector<std::string> overlays() const override;
    std::optional<Overlay> overlay(const std::string& name) override;
    std::optional<SampleGrid> samples(glm::ivec2 pixel) override;
    void forget_samples() override { samples_ = {}; }
    std::string method() const override;
    std::vector<std::string> rivals() const override;
    std::unique_ptr<Technique> rival(const std::string& name) override;
    std::vector<std::pair<std::string, std::string>> facts() override;

    const VolumePlacement& placement() const { return placement_; }

private:
    void load() override;
    void relight() override;
    std::unique_ptr<SurfaceVolume> make(const VolumeGiParams& params) const override;
    std::unique_ptr<SurfaceVolume> make(const SurfaceVolumeParams& params) const;

    /// The samples of one pixel of a picture of that size, as a picture of their own.
    struct Samples {
        std::unique_ptr<SurfaceVolume> picture;
        glm::uvec2 size{0};
        glm::ivec2 pixel{0};
    };
    std::optional<SurfaceVolumeOptions> own_; ///< of a rival
    const SurfaceVolumeOptions& options_;
    std::shared_ptr<const LitScene> lit_;
    VolumePlacement placement_;
    Samples samples_;
};

} // namespace ockham::viewer
